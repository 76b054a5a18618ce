/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The illuminator as a MAVLink component: commands 405 and 406, messages 440, 396 and those that
 * every component has, with the device's parameters, but for the gimbal's, and files. Floats of
 * commands 405 and 406 end here; the core has integers.
 *
 * ILLUMINATOR_STATUS reports what was commanded. A float comes back exactly as 406 brought it, as
 * long as it is still what the core holds; after a change by someone else it is the core's value.
 *
 * Context: the endpoint's. Spec: MAVLink common 405, 406, 440, 396.
 */
#ifndef PHAROS_PROTO_MAVLINK_ILLUMINATOR_SERVICE_H
#define PHAROS_PROTO_MAVLINK_ILLUMINATOR_SERVICE_H

#include "core/device.h"
#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/ftp.h"
#include "proto/mavlink/identity.h"
#include "proto/mavlink/param_service.h"
#include "proto/mavlink/self_test_service.h"

/* A number of the wire and what it means to the core. */
struct mavlink_echo {
	float wire;
	uint32_t core;
};

struct mavlink_illuminator {
	struct pharos_device *device;
	uint8_t lamp; /* the one that this component is */
	const struct mavlink_identity *identity;
	struct mavlink_params params;
	struct mavlink_self_test self_test;
#ifdef CONFIG_PHAROS_FTP
	struct mavlink_ftp ftp;
#endif
	struct mavlink_echo brightness;
	struct mavlink_echo period;
	struct mavlink_echo duty;
	int64_t noticed_us[MAVLINK_NOTICE_KINDS]; /* -1: never */
};

extern const struct mavlink_profile mavlink_illuminator_profile;

/* Both outlive the service. */
void mavlink_illuminator_init(struct mavlink_illuminator *self, struct pharos_device *device,
                              uint8_t lamp, const struct mavlink_identity *identity);

#endif
