/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The illuminator's parameters in one file, as ArduPilot packs them: ground stations read
 * "@PARAM/param.pck" over MAVLink FTP instead of asking for a list.
 *
 *   u16 0x671B, or 0x671C with defaults; u16 parameters in the file; u16 parameters in all
 *   of each: u8 type, and 0x10 when its default follows the value
 *            u8 bytes of its name that are those of the name before; the rest's length - 1, << 4
 *            the rest of the name, the value, the default where it is another
 *
 * Little endian, values as PARAM_VALUE has them. The file is of one instant: what was taken.
 *
 * Any context. Spec: libraries/AP_Filesystem/README.md of ArduPilot, "parameter listing".
 */
#ifndef PHAROS_PROTO_MAVLINK_PARAM_PACK_H
#define PHAROS_PROTO_MAVLINK_PARAM_PACK_H

#include "core/params.h"

#include <stdbool.h>
#include <stdint.h>

struct mavlink_param_pack {
	int32_t values[PARAM_COUNT];
};

/* The values of now: those that the illuminator lists over MAVLink (param_service.h). */
void mavlink_param_pack_take(struct mavlink_param_pack *self, const struct params *params);

/* Those that have another value by now. */
struct param_set mavlink_param_pack_outdated(const struct mavlink_param_pack *self,
                                             const struct params *params);

uint32_t mavlink_param_pack_length(const struct mavlink_param_pack *self, bool with_defaults);

/* count bytes from offset on, which all lie within the length. */
void mavlink_param_pack_read(const struct mavlink_param_pack *self, bool with_defaults,
                             uint32_t offset, uint8_t count, uint8_t *to);

#endif
