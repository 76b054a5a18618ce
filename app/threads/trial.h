/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A new image runs on trial: once it has shown that it does all that the last one did, it is
 * confirmed. One that never does is taken back by the bootloader at the next reset.
 */
#ifndef PHAROS_THREADS_TRIAL_H
#define PHAROS_THREADS_TRIAL_H

/* For so long nothing is decided. */
#define TRIAL_MS 10000

#ifdef CONFIG_PHAROS_FIRMWARE_UPDATE
/* Once, when everything has been started. */
void trial_start(void);
#else
static inline void trial_start(void)
{
}
#endif

#endif
