/* SPDX-License-Identifier: Apache-2.0 */
#include "gimbal_fixture.h"

struct gimbal *const gimbal = &device.gimbal;
struct arbiter *const gimbal_arbiter = &device.gimbal_arbiter;
struct mavlink_gimbal its;

static const struct mavlink_identity who = {
	.vendor_name = "Pharos",
	.model_name = "Light",
	.software_version = "1.2.3",
	.hardware_version = "4.5.6",
	.serial_number = "0123456789abcdef0011",
	.version_code = 0x01020300,
};

void gimbal_fixture_before(void *unused)
{
	struct gimbal_config config;

	fixture_before(unused);
	params_gimbal(device_params, &config);
	config.axes[GIMBAL_PAN].rate_mdeg_per_s = 100000;
	config.axes[GIMBAL_TILT].rate_mdeg_per_s = 100000;
	gimbal_init(gimbal, now_us, &config);
	mavlink_gimbal_init(&its, &device, &who);
	mavlink_endpoint_add(&endpoint, now_us, 154, &mavlink_gimbal_profile, &its);
}

void say(uint8_t system, uint8_t component, const struct mavlink_kind *kind, const void *payload)
{
	const struct mavlink_sender sender = {
		.version = 2, .system_id = system, .component_id = component};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(1, bytes, mavlink_frame_build(bytes, &sender, kind, payload));
}

void vehicle_beats(void)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const mavlink_heartbeat_t heartbeat = {.type = 2, .autopilot = 3}; /* ArduCopter */

	say(1, 1, &kind, &heartbeat);
}

void vehicle_attitude(float roll, float pitch, float yaw)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(ATTITUDE);
	const mavlink_attitude_t attitude = {.roll = roll, .pitch = pitch, .yaw = yaw};

	say(1, 1, &kind, &attitude);
}

void set_attitude(struct setpoint setpoint)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(GIMBAL_DEVICE_SET_ATTITUDE);
	mavlink_gimbal_device_set_attitude_t wire = {
		.flags = setpoint.flags,
		.angular_velocity_x = setpoint.rates[0],
		.angular_velocity_y = setpoint.rates[1],
		.angular_velocity_z = setpoint.rates[2],
		.target_system = 1,
		.target_component = 154,
	};

	memcpy(wire.q, setpoint.q, sizeof(setpoint.q));
	say(1, 1, &kind, &wire);
	zassert_equal(out.count, 0, "284 is not answered");
}

void pass(int64_t duration_us)
{
	const int64_t until_us = now_us + duration_us;
	struct gimbal_outbox moves;

	while (gimbal_deadline_us(gimbal) <= until_us) {
		now_us = gimbal_deadline_us(gimbal);
		gimbal_advance(gimbal, now_us, &moves);
	}
	now_us = until_us;
}

void assert_at(int32_t pan_mdeg, int32_t tilt_mdeg)
{
	const struct direction own = gimbal_report(gimbal, now_us).own;

	zassert_within(own.yaw_mdeg, pan_mdeg, 5, "pan %d, not %d", own.yaw_mdeg, pan_mdeg);
	zassert_within(own.pitch_mdeg, tilt_mdeg, 5, "tilt %d, not %d", own.pitch_mdeg, tilt_mdeg);
}

struct sums idle(int64_t duration_us)
{
	const int64_t until_us = now_us + duration_us;
	struct sums sums = {0};

	while (mavlink_endpoint_deadline_us(&endpoint) < until_us) {
		const int64_t due_us = mavlink_endpoint_deadline_us(&endpoint);

		now_us = due_us > now_us ? due_us : now_us;
		mavlink_endpoint_step(&endpoint, now_us, &out);
		for (uint16_t i = 0; i < out.count; i++) {
			const struct mavlink_frame frame = sent(i);
			const bool ours = frame.component_id == 154;

			sums.heartbeats[out.frames[i].link] += ours && frame.message_id == 0;
			sums.attitudes[out.frames[i].link] += ours && frame.message_id == 285;
		}
	}
	now_us = until_us;
	return sums;
}

uint8_t order(uint16_t id, struct command_params with)
{
	mavlink_command_ack_t ack;

	receive_long(0, 1, 154, id, with);
	zassert_true(out.count >= 1);

	const struct mavlink_frame frame = sent(0);

	zassert_equal(frame.message_id, 77); /* COMMAND_ACK */
	zassert_equal(frame.component_id, 154);
	mavlink_frame_payload(&frame, &ack, sizeof(ack));
	zassert_equal(ack.command, id);
	return ack.result;
}

void asked(uint32_t id, void *payload, size_t size)
{
	zassert_equal(ORDER(512, (float)id), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 2);

	const struct mavlink_frame frame = sent(1);

	zassert_equal(frame.message_id, id);
	mavlink_frame_payload(&frame, payload, size);
}

mavlink_gimbal_device_attitude_status_t status(void)
{
	mavlink_gimbal_device_attitude_status_t wire;

	asked(285, &wire, sizeof(wire));
	return wire;
}

void assert_q(const mavlink_gimbal_device_attitude_status_t *wire, const float q[4])
{
	float is[4];

	memcpy(is, wire->q, sizeof(is));
	for (size_t i = 0; i < 4; i++) {
		zassert_within(is[i], q[i], 1e-4f, "%u: %d ppm, not %d", (unsigned int)i,
		               (int)(is[i] * 1e6f), (int)(q[i] * 1e6f));
	}
}
