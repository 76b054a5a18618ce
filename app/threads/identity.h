/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who this device is, from the build's configuration and the chip's own id.
 */
#ifndef PHAROS_THREADS_IDENTITY_H
#define PHAROS_THREADS_IDENTITY_H

#include "proto/mavlink/identity.h"

/* The same every time; first call from one thread only. */
const struct mavlink_identity *identity_get(void);

#endif
