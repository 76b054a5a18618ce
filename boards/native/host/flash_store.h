/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The MCU's program flash with its two image slots, in a file of the host's (--flash FILE) or in
 * memory. Before the kernel starts, the bootloader's model has run on it.
 *
 * In virtual time the file is the memory. In real time memory is a copy, and what is changed is
 * written by a helper, since a slow disk would stop the process at its first touch.
 */
#ifndef NATIVE_HOST_FLASH_STORE_H_
#define NATIVE_HOST_FLASH_STORE_H_

#include "models/flash.h"

/* As the partitions in native.dts. */
#define FLASH_SLOT_SIZE  229376u /* 224 KiB */
#define FLASH_STORE_SIZE (2u * FLASH_SLOT_SIZE)

struct flash *flash_store(void);

/* After a write or an erasure: the calling thread of the device waits until these bytes are in the
 * file, too. 0 or -errno. */
int flash_store_keep(uint32_t offset, uint32_t size);

#endif
