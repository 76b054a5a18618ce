/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The generated dialect: message structs, ids, lengths and enums.
 *
 * Of the generated library only types and constants are used. Its parser and its packing functions
 * keep per-channel state in function-local statics, one copy for each file that includes them;
 * frame.c and framer.c do that work here. MAVLINK_SEPARATE_HELPERS keeps those copies out.
 *
 * Payload structs lie in wire order, little-endian as the machines this runs on; some have padding
 * behind the last field.
 */
#ifndef PHAROS_PROTO_MAVLINK_DIALECT_H
#define PHAROS_PROTO_MAVLINK_DIALECT_H

#define MAVLINK_SEPARATE_HELPERS
#include <pharos/mavlink.h>

#include <stddef.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "payload structs are wire images");

/* MAVLink common.xml, as of mid 2026. */
_Static_assert(MAVLINK_MSG_ID_ILLUMINATOR_STATUS == 440, "common.xml");
_Static_assert(MAVLINK_MSG_ID_ILLUMINATOR_STATUS_CRC == 66, "common.xml");
_Static_assert(MAVLINK_MSG_ID_ILLUMINATOR_STATUS_LEN == 35, "common.xml");
_Static_assert(offsetof(mavlink_illuminator_status_t, max_strobe_period) == 28, "wire order");
_Static_assert(offsetof(mavlink_illuminator_status_t, mode) == 34, "wire order");
_Static_assert(MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC == 396, "common.xml");
_Static_assert(MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC_CRC == 50, "common.xml");
_Static_assert(MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC_LEN == 160, "common.xml");
_Static_assert(offsetof(mavlink_component_information_basic_t, serial_number) == 128, "wire order");
_Static_assert(MAVLINK_MSG_ID_COMPONENT_METADATA == 397, "common.xml");
_Static_assert(MAVLINK_MSG_ID_COMPONENT_METADATA_CRC == 182, "common.xml");
_Static_assert(MAVLINK_MSG_ID_PARAM_ERROR == 345, "common.xml");
_Static_assert(MAVLINK_MSG_ID_PARAM_ERROR_CRC == 209, "common.xml");
_Static_assert(MAV_PARAM_ERROR_TYPE_UNSUPPORTED == 6, "common.xml");
_Static_assert(MAVLINK_MSG_ID_COMMAND_CANCEL == 80, "common.xml");
_Static_assert(MAVLINK_MSG_ID_COMMAND_CANCEL_CRC == 14, "common.xml");
_Static_assert(MAV_RESULT_CANCELLED == 6, "common.xml");
_Static_assert(MAV_TYPE_ILLUMINATOR == 44, "minimal.xml");
_Static_assert(MAV_COMP_ID_ILLUMINATOR == 243, "minimal.xml");
_Static_assert(MAV_CMD_ILLUMINATOR_ON_OFF == 405, "common.xml");
_Static_assert(MAV_CMD_DO_ILLUMINATOR_CONFIGURE == 406, "common.xml");

#endif
