/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Plain DroneCAN control of the light, for vehicles without MAVLink; sans-IO.
 *
 * LightsCommand with our light id: brightness = max(red/31, green/63, blue/31); 0 is off, more is
 * that brightness and on. hardpoint.Command with our hardpoint id: 0 off, else on.
 * actuator.ArrayCommand with one of our actuator ids: brightness, pan or tilt; unitless -1…1, or
 * pulses of 1000…2000 us (beyond these ends: the end; beyond 500…2500 us, NaN and infinite: refused
 * and counted).
 *
 * Vehicles repeat these many times per second. A repetition is marked, so that it does not take the
 * light back from whoever commanded it since. What was refused counts as new when it comes again.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_DRONECAN_LIGHTS_H
#define PHAROS_PROTO_DRONECAN_LIGHTS_H

#include "core/device.h"
#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stdint.h>

#define DRONECAN_LIGHTS_ID_NONE (-1)

/* Ids 0…255 as on the wire, DRONECAN_LIGHTS_ID_NONE: not used. */
struct dronecan_lights_config {
	int16_t light_id;
	int16_t hardpoint_id;
	int16_t brightness_actuator_id;
	int16_t pan_actuator_id;
	int16_t tilt_actuator_id;
};

/* What is told about the lamp. temp_mdegc only with temp_valid. */
struct dronecan_lights_report {
	bool on; /* as commanded */
	bool temp_valid;
	bool overheating;
	int32_t temp_mdegc;
};

struct dronecan_lights_stats {
	uint32_t commands; /* that were for us */
	uint32_t malformed;
	uint32_t refused; /* no number, or a value or type of no meaning here */
	uint32_t applied;
	uint32_t rejected;  /* by the device */
	uint32_t kept;      /* repetitions while somebody else is in command */
	uint32_t no_gimbal; /* pan and tilt, but there is none */
};

enum dronecan_lights_source {
	DRONECAN_LIGHTS_SOURCE_LIGHT,
	DRONECAN_LIGHTS_SOURCE_HARDPOINT,
	DRONECAN_LIGHTS_SOURCE_BRIGHTNESS,
	DRONECAN_LIGHTS_SOURCE_PAN,
	DRONECAN_LIGHTS_SOURCE_TILT,
	DRONECAN_LIGHTS_SOURCES,
};

struct dronecan_lights {
	struct pharos_device *device;
	struct dronecan_lights_config config;
	struct dronecan_lights_stats stats;
	struct dronecan_lights_report report;
	int64_t report_us;
	int32_t last[DRONECAN_LIGHTS_SOURCES]; /* what each source commanded; INT32_MIN: nothing */
};

/* device: kept by reference. */
void dronecan_lights_init(struct dronecan_lights *self, int64_t now_us,
                          const struct dronecan_lights_config *config,
                          struct pharos_device *device);
void dronecan_lights_configure(struct dronecan_lights *self,
                               const struct dronecan_lights_config *config);

/* One of the three commands (others: ignored): carried out. */
void dronecan_lights_receive(struct dronecan_lights *self, int64_t now_us,
                             const struct dronecan_transfer *transfer);

/* hardpoint.Status at once when `on` changes, else each second; Temperature each second. */
void dronecan_lights_set_report(struct dronecan_lights *self, int64_t now_us,
                                const struct dronecan_lights_report *report);
void dronecan_lights_step(struct dronecan_lights *self, int64_t now_us,
                          struct dronecan_transport *transport);
int64_t dronecan_lights_deadline_us(const struct dronecan_lights *self);

#endif
