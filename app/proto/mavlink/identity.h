/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who the device is. Strings are constant and never NULL; what does not fit its field with a
 * terminating 0 is cut. MAVLink COMPONENT_INFORMATION_BASIC 396.
 */
#ifndef PHAROS_PROTO_MAVLINK_IDENTITY_H
#define PHAROS_PROTO_MAVLINK_IDENTITY_H

#include <stdint.h>

struct mavlink_files;

struct mavlink_identity {
	const char *vendor_name;      /* 31 bytes */
	const char *model_name;       /* 31 */
	const char *software_version; /* 23, "major.minor.patch" */
	const char *hardware_version; /* 23 */
	const char *serial_number;    /* 31 */
	/* What MAVLink FTP serves, first the general metadata; CONFIG_PHAROS_FTP, else NULL. */
	const struct mavlink_files *files;
	uint32_t time_manufacture_s; /* Unix time; 0: not known */
	uint32_t version_code;       /* AUTOPILOT_VERSION: major, minor, patch, type, a byte each */
};

#endif
