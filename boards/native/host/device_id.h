/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a chip's serial number is to a board: an id that stays, and that no other light has.
 *
 * Of --device-id; else in virtual time, or with --seed, from the seed, so that a run can be
 * repeated; else from this host's id and the settings file, which one light at a time can have;
 * else from this host's id and a place: the first light that runs has the first one.
 */
#ifndef NATIVE_HOST_DEVICE_ID_H_
#define NATIVE_HOST_DEVICE_ID_H_

#include <stdint.h>

/* Never 0. After the start hooks. */
uint64_t device_id(void);

/* The settings file is this one, and open. Start hooks only. */
void device_id_keep_with(const char *path);

#endif
