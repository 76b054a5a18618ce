/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What firmware says to MCUboot, through the slots' trailers. By Zephyr's names; threads.
 */
#ifndef ZEPHYR_DFU_MCUBOOT_H_
#define ZEPHYR_DFU_MCUBOOT_H_

#include <stdbool.h>

#define BOOT_UPGRADE_TEST      0
#define BOOT_UPGRADE_PERMANENT 1

/* The image in the second slot starts at the next reset. 0 or -errno. */
int boot_request_upgrade(int permanent);

/* The running image stays, or is the only one there ever was. */
bool boot_is_img_confirmed(void);

/* The running image works: it stays. 0 or -errno; also when there is nothing to confirm. */
int boot_write_img_confirmed(void);

#endif
