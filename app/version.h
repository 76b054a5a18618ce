/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Version of the firmware, as told over every protocol.
 */
#ifndef PHAROS_VERSION_H
#define PHAROS_VERSION_H

#define PHAROS_VERSION_MAJOR 0
#define PHAROS_VERSION_MINOR 1
#define PHAROS_VERSION_PATCH 0
#define PHAROS_VERSION       "0.1.0"

#endif
