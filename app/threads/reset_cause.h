/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Why the firmware last started, and which thread was to blame where one was.
 */
#ifndef PHAROS_THREADS_RESET_CAUSE_H
#define PHAROS_THREADS_RESET_CAUSE_H

#include <stdint.h>

#define RESET_CAUSE_TEXT_MAX 48

/* Reads the hardware's cause; once, before the threads start. */
void reset_cause_init(void);

/* "power-on", "watchdog (thread command stalled)", "software", … Any context. */
void reset_cause_text(char text[RESET_CAUSE_TEXT_MAX]);

/* Remembers, over the reset that will follow, which thread stalls; NULL: none does.
 * Any context.
 */
void reset_cause_blame(const char *thread);

#endif
