/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who this device is, from the build's configuration and the chip's own id.
 */
#ifndef PHAROS_THREADS_IDENTITY_H
#define PHAROS_THREADS_IDENTITY_H

#include "proto/mavlink/identity.h"
#include "threads/reset_cause.h"
#include "version.h"

#define IDENTITY_BOOT_TEXT_MAX (sizeof("Pharos : " PHAROS_VERSION) + RESET_CAUSE_TEXT_MAX)

/* The same every time; first call from one thread only. */
const struct mavlink_identity *identity_get(void);

/* What is told once after each start: "Pharos 0.1.0: power-on". Any context. */
void identity_boot_text(char text[IDENTITY_BOOT_TEXT_MAX]);

#endif
