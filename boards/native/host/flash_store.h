/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The MCU's program flash with its two image slots, in a file of the host's (--flash FILE) or in
 * memory. Before the kernel starts, the bootloader's model has run on it.
 */
#ifndef NATIVE_HOST_FLASH_STORE_H_
#define NATIVE_HOST_FLASH_STORE_H_

#include "models/flash.h"

/* As the partitions in native.dts. */
#define FLASH_SLOT_SIZE  229376u /* 224 KiB */
#define FLASH_STORE_SIZE (2u * FLASH_SLOT_SIZE)

struct flash *flash_store(void);

#endif
