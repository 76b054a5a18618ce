/* SPDX-License-Identifier: Apache-2.0 */
/*
 * C11's NAN, INFINITY and isnan(), also where the C library's <math.h> lacks them, as Zephyr's
 * minimal one.
 */
#ifndef PHAROS_PROTO_MAVLINK_REAL_H
#define PHAROS_PROTO_MAVLINK_REAL_H

#include <math.h>

#ifndef NAN
#define NAN __builtin_nanf("")
#endif

#ifndef INFINITY
#define INFINITY __builtin_inff()
#endif

#ifndef isnan
#define isnan(x) __builtin_isnan(x)
#endif

#endif
