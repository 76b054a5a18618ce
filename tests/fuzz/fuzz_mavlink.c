/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzzes the MAVLink framer and endpoint with a core behind them, over a small script:
 *
 *   op 0…3   bytes follow (count first): they arrive on that link as they are
 *   op 4…7   a message follows: id and payload; it arrives on link op - 4 as a good frame
 *   op 8     time moves, the endpoint steps until it is content
 *   op 9     the thermal supervisor reports
 *   op 10    the line falls silent
 *   op 11    a signing key is set or forgotten, routing turned on or off, links made secure
 *   op 12    a signed message follows, perhaps changed afterwards; it arrives twice
 *   op 13    SETUP_SIGNING follows
 *   op 14    bytes follow, for two framers of which one lets unknown messages out, and for two of
 *            which one is given them as it wants them
 *
 * Holds after each: what is sent are whole, good frames of ours, rightly signed with rising
 * timestamps while there is a key; settings are in range, the gimbal within its limits; a command
 * that was not accepted, or that was not rightly signed while there is a key, or that was repeated,
 * changed nothing; what is forwarded goes to other links that are up, and is never SETUP_SIGNING;
 * unknown messages cost no verified frame.
 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/framer.h"
#include "proto/mavlink/gimbal_service.h"
#include "proto/mavlink/illuminator_service.h"

#include "check.h"

#include <string.h>

struct script {
	const uint8_t *at;
	const uint8_t *end;
};

static struct pharos_device device;
static struct illuminator *const light = &device.lamps[0].illuminator;
static struct gimbal *const gimbal = &device.gimbal;
static struct mavlink_illuminator service;
static struct mavlink_gimbal gimbal_service;
static struct mavlink_endpoint endpoint;
static struct mavlink_outbox out;
static struct mavlink_framer framers[MAVLINK_LINKS_MAX];
static int64_t now_us;

/* The arriving frame is rightly signed and new. */
static bool trusted;
/* The last timestamp sent on each link, with this key. */
static uint64_t stamps[MAVLINK_LINKS_MAX];
static struct mavlink_signing_record stamped;

static const uint8_t big[1000];

static const struct mavlink_file served[] = {
	{"a", big, sizeof(big), 1},
	{"b", big, 1, 2},
	{"c", big, 0, 3},
};

static const struct mavlink_files files = {served, 3};

static const struct mavlink_identity identity = {
	.vendor_name = "a",
	.model_name = "b",
	.software_version = "c",
	.hardware_version = "d",
	.serial_number = "e",
	.files = &files,
};

static void start(void)
{
	const struct device_config board = {.gimbal = true};
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 0x0F};

	now_us = 0;
	trusted = false;
	memset(&stamped, 0, sizeof(stamped));
	memset(stamps, 0, sizeof(stamps));
	params_init(&device.params);
	device.params.values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&device, 0, &board);
	mavlink_illuminator_init(&service, &device, 0, &identity);
	mavlink_endpoint_init(&endpoint, &config);
	mavlink_endpoint_add(&endpoint, 0, 243, &mavlink_illuminator_profile, &service);
	mavlink_gimbal_init(&gimbal_service, &device, &identity);
	mavlink_endpoint_add(&endpoint, 0, 154, &mavlink_gimbal_profile, &gimbal_service);
	for (size_t i = 0; i < MAVLINK_LINKS_MAX; i++) {
		mavlink_framer_init(&framers[i]);
	}
}

/* As the command thread does it. */
static void settle(void)
{
	struct device_effects effects;

	if (pharos_device_take(&device, &effects)) {
		mavlink_endpoint_tell(&endpoint, now_us, &effects);
	}
}

static uint8_t take(struct script *script)
{
	return script->at < script->end ? *script->at++ : 0;
}

static void check_light(void)
{
	const struct illuminator_settings *const s = &light->settings;

	CHECK(s->mode == ILLUMINATOR_MODE_INTERNAL || s->mode == ILLUMINATOR_MODE_SYNC);
	CHECK(s->brightness_ppm <= PPM_ONE && s->duty_ppm <= PPM_ONE);
	CHECK(s->strobe_period_us == 0 ||
	      (s->strobe_period_us >= 1000 && s->strobe_period_us <= 60000000));
}

/* While there is a key, a frame sent has a signature that another takes, with a newer timestamp. */
static void check_signature(const struct mavlink_frame *frame, uint8_t link)
{
	struct mavlink_signing_record record = endpoint.signing.now;
	struct mavlink_signing listener;

	CHECK(frame->has_signature == endpoint.signing.on);
	if (!frame->has_signature) {
		return;
	}
	if (memcmp(stamped.key, record.key, sizeof(record.key)) != 0) {
		stamped = record;
		memset(stamps, 0, sizeof(stamps));
	}
	record.timestamp = 0;
	mavlink_signing_init(&listener, 0, &record);
	CHECK(mavlink_signing_check(&listener, 0, frame) == MAVLINK_SIGNING_ACCEPTED);
	CHECK(listener.now.timestamp > stamps[link] ||
	      listener.now.timestamp == MAVLINK_TIMESTAMP_MAX);
	stamps[link] = listener.now.timestamp;
}

static void check_gimbal(void)
{
	const struct gimbal_report report = gimbal_report(gimbal, now_us);

	/* what any parameters allow; those that are set are in force */
	CHECK(report.own.yaw_mdeg >= -GIMBAL_ANGLE_MAX_MDEG &&
	      report.own.yaw_mdeg <= GIMBAL_ANGLE_MAX_MDEG);
	CHECK(report.own.pitch_mdeg >= -GIMBAL_ANGLE_MAX_MDEG &&
	      report.own.pitch_mdeg <= GIMBAL_ANGLE_MAX_MDEG);
	CHECK(report.level.pitch_mdeg >= -90001 && report.level.pitch_mdeg <= 90001);
}

/* Within what any servo takes, whatever the parameters say. */
static void check_servos(void)
{
	CHECK(gimbal_deadline_us(gimbal) > now_us);
	for (int i = 0; i < GIMBAL_AXES; i++) {
		CHECK(gimbal->pulse_ns[i] >= 1000u * GIMBAL_PULSE_MIN_US &&
		      gimbal->pulse_ns[i] <= 1000u * GIMBAL_PULSE_MAX_US);
	}
	check_gimbal();
}

/* Every frame sent passes a fresh framer; returns how many were acknowledgements of result. */
static unsigned int check_sent(uint8_t result)
{
	unsigned int found = 0;

	for (uint16_t i = 0; i < out.count; i++) {
		struct mavlink_framer framer;
		struct mavlink_frame frame;

		mavlink_framer_init(&framer);
		CHECK(out.frames[i].link < MAVLINK_LINKS_MAX);
		mavlink_framer_write(&framer, out.bytes + out.frames[i].offset,
		                     out.frames[i].length);
		CHECK(mavlink_framer_next(&framer, &frame));
		CHECK(frame.length == out.frames[i].length);
		CHECK(frame.system_id == 1);
		CHECK(frame.component_id == 243 || frame.component_id == 154);
		check_signature(&frame, out.frames[i].link);
		if (frame.message_id == MAVLINK_MSG_ID_COMMAND_ACK) {
			found += mavlink_frame_byte(&frame, 2) == result;
		}
	}
	return found;
}

static void check_forward(uint8_t link, const uint8_t *bytes, size_t length)
{
	struct mavlink_frame frame;

	CHECK(out.forward == 0 || endpoint.config.routing);
	CHECK((out.forward & 1u << link) == 0 && (out.forward & ~endpoint.config.links) == 0);
	if (out.forward != 0) {
		CHECK(mavlink_frame_view(bytes, length, &frame));
		CHECK(frame.message_id != MAVLINK_MSG_ID_SETUP_SIGNING);
		CHECK(frame.system_id != 1 || frame.component_id != 243);
	}
	CHECK(endpoint.router.count <= MAVLINK_ROUTES_MAX);
}

static void arrive(uint8_t link, const uint8_t *bytes, size_t length)
{
	const uint32_t revision = light->revision;
	const bool refuses = endpoint.signing.on && !trusted;

	mavlink_endpoint_receive(&endpoint, now_us, link, bytes, length, &out);
	check_forward(link, bytes, length);
	CHECK(!refuses || (out.command == 0 && light->revision == revision));
	CHECK(out.count <= MAVLINK_COMPONENTS_MAX * (1 + MAVLINK_LINKS_MAX));
	if (check_sent(MAV_RESULT_ACCEPTED) == 0) {
		CHECK(light->revision == revision);
	}
	settle();
	check_light();
	check_gimbal();
}

static void raw(struct script *script, uint8_t link)
{
	size_t count = take(script);
	struct mavlink_frame frame;

	while (count > 0 && script->at < script->end) {
		size_t offered = (size_t)(script->end - script->at);

		offered = offered < count ? offered : count;

		const size_t taken = mavlink_framer_write(&framers[link], script->at, offered);

		CHECK(taken > 0);
		script->at += taken;
		count -= taken;
		while (mavlink_framer_next(&framers[link], &frame)) {
			arrive(link, frame.bytes, frame.length);
		}
	}
}

static void message(struct script *script, uint8_t link)
{
	static const uint16_t ids[32] = {76,  75, 0,  4,  111, 440, 300, 77,  110, 110, 110,
	                                 110, 20, 21, 23, 80,  284, 284, 284, 284, 286, 286,
	                                 286, 30, 30, 33, 33,  0,   285, 283, 76,  75};
	const uint8_t choice = take(script);
	const struct mavlink_sender sender = {
		.version = choice & 0x80 ? 1 : 2,
		.system_id = choice & 0x40 ? 1 : 255,
		.component_id = choice & 0x20 ? (choice & 0x10 ? 1 : 243) : 190,
	};
	struct mavlink_kind kind = {.id = ids[choice & 31]};
	uint8_t payload[MAVLINK_PAYLOAD_MAX] = {0};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	kind.length = take(script);
	kind.length = kind.length == 0 ? 1 : kind.length;
	kind.min_length = kind.length;
	CHECK(mavlink_crc_extra(kind.id, &kind.crc_extra));
	for (size_t i = 0; i < kind.length; i++) {
		payload[i] = take(script);
	}

	const size_t length = mavlink_frame_build(bytes, &sender, &kind, payload);

	if (length > 0) {
		arrive(link, bytes, length);
	}
}

static void configure(struct script *script)
{
	const uint8_t choice = take(script);
	struct mavlink_signing_record record = {.timestamp = (uint64_t)take(script) << 40};

	memset(record.key, choice & 3, sizeof(record.key));
	if ((choice & 4) != 0) {
		mavlink_endpoint_set_key(&endpoint, now_us, &record);
		memset(&stamped, 0, sizeof(stamped));
	}
	mavlink_endpoint_set_routing(&endpoint, (choice & 8) != 0);
	mavlink_endpoint_set_secure_links(&endpoint, choice >> 4);
	for (size_t i = 0; i < MAVLINK_LINKS_MAX; i++) {
		framers[i].opaque = (choice & 8) != 0;
	}
}

static void signed_message(struct script *script)
{
	const uint8_t link = take(script) & 3;
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 255, .component_id = 190, .has_signature = true};
	const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t command = {.command = 405, .param1 = take(script) & 1};
	struct mavlink_signing_record record = endpoint.signing.now;
	const int64_t shift = (int64_t)(int8_t)take(script) * 100000;
	struct mavlink_signing peer;
	uint8_t bytes[MAVLINK_FRAME_MAX];
	size_t length = mavlink_frame_build(bytes, &sender, &kind, &command);

	if (!endpoint.signing.on) {
		return;
	}
	record.timestamp = mavlink_signing_timestamp(&endpoint.signing, now_us);
	record.timestamp = shift < 0 && record.timestamp < (uint64_t)-shift
	                           ? 0
	                           : record.timestamp + (uint64_t)shift;
	mavlink_signing_init(&peer, now_us, &record);
	length += mavlink_signing_sign(&peer, now_us, bytes, length, take(script) & 31);

	const uint8_t at = take(script);
	const uint8_t change = take(script);

	if (at < length) {
		bytes[at] ^= change;
	}
	trusted = at >= length || change == 0;
	arrive(link, bytes, length);
	trusted = false;
	arrive(link ^ 1, bytes, length);
}

static void setup(struct script *script)
{
	const struct mavlink_sender sender = {.version = 2, .system_id = 255, .component_id = 190};
	const struct mavlink_kind kind = MAVLINK_KIND(SETUP_SIGNING);
	const uint8_t link = take(script) & 3;
	const uint8_t choice = take(script);
	mavlink_setup_signing_t wire = {.initial_timestamp = (uint64_t)take(script) << 42,
	                                .target_system = choice & 1,
	                                .target_component = choice & 2 ? 243 : 0};
	const struct mavlink_signing_record before = endpoint.signing.now;
	const uint8_t secure = endpoint.config.secure_links;
	const bool had_key = endpoint.signing.on;
	uint8_t bytes[MAVLINK_FRAME_MAX];

	memset(wire.secret_key, choice >> 6, sizeof(wire.secret_key));
	arrive(link, bytes, mavlink_frame_build(bytes, &sender, &kind, &wire));
	/* it is not signed: only where there is no key yet */
	if (had_key || (choice & 3) != 3 || (secure & 1u << link) == 0) {
		CHECK(memcmp(before.key, endpoint.signing.now.key, sizeof(before.key)) == 0);
	} else {
		CHECK(memcmp(wire.secret_key, endpoint.signing.now.key, sizeof(before.key)) == 0);
		memset(&stamped, 0, sizeof(stamped));
	}
}

/* The next frame of a framer that can be verified. */
static bool next_verified(struct mavlink_framer *framer, struct mavlink_frame *frame)
{
	uint8_t crc_extra;

	while (mavlink_framer_next(framer, frame)) {
		if (mavlink_crc_extra(frame->message_id, &crc_extra)) {
			return true;
		}
	}
	return false;
}

/* A framer that gets bytes only when it has as many as it wanted finds the same frames as soon. */
static void compare_wanted(const uint8_t *bytes, size_t size, bool opaque)
{
	static struct mavlink_framer eager;
	static struct mavlink_framer patient;
	struct mavlink_frame frame;
	size_t given = 0;

	mavlink_framer_init(&eager);
	mavlink_framer_init(&patient);
	eager.opaque = opaque;
	patient.opaque = opaque;
	for (size_t come = 1; come <= size; come++) {
		const size_t wanted = mavlink_framer_wanted(&patient);

		CHECK(wanted >= 1 && wanted <= MAVLINK_FRAME_MAX);
		CHECK(mavlink_framer_write(&eager, bytes + come - 1, 1) == 1);
		while (mavlink_framer_next(&eager, &frame)) {
		}
		if (come - given < wanted) {
			CHECK(eager.stats.frames == patient.stats.frames);
			continue;
		}
		while (given < come) {
			given += mavlink_framer_write(&patient, bytes + given, come - given);
			while (mavlink_framer_next(&patient, &frame)) {
			}
		}
		CHECK(memcmp(&eager.stats, &patient.stats, sizeof(eager.stats)) == 0);
	}
}

/* What a router's framer verifies is what the other does, in its order, at most later. */
static void compare_framers(struct script *script)
{
	static struct mavlink_framer plain;
	static struct mavlink_framer router;
	static uint8_t found[1024 / MAVLINK_V1_FRAME_MIN][MAVLINK_FRAME_MAX];
	struct mavlink_frame frame;
	size_t ahead = 0;
	size_t behind = 0;
	size_t count = 4u * take(script);
	const size_t chunk = 1u + take(script);
	const size_t left = (size_t)(script->end - script->at);

	compare_wanted(script->at, count < left ? count : left, (chunk & 1) != 0);
	mavlink_framer_init(&plain);
	mavlink_framer_init(&router);
	router.opaque = true;
	while (count > 0 && script->at < script->end) {
		size_t size = (size_t)(script->end - script->at);

		size = size < chunk ? size : chunk;
		size = size < count ? size : count;
		for (size_t used = 0; used < size;) {
			used += mavlink_framer_write(&plain, script->at + used, size - used);
			while (next_verified(&plain, &frame)) {
				memcpy(found[ahead++], frame.bytes, frame.length);
			}
		}
		for (size_t used = 0; used < size;) {
			const size_t taken =
				mavlink_framer_write(&router, script->at + used, size - used);

			CHECK(taken > 0);
			used += taken;
			while (next_verified(&router, &frame)) {
				CHECK(behind < ahead);
				CHECK(memcmp(found[behind++], frame.bytes, frame.length) == 0);
			}
		}
		script->at += size;
		count -= size;
	}
}

static void time_moves(struct script *script)
{
	int steps = 0;

	now_us += (int64_t)take(script) * 100000 + take(script);
	pharos_device_step(&device, now_us);
	settle();
	while (mavlink_endpoint_deadline_us(&endpoint) <= now_us) {
		mavlink_endpoint_step(&endpoint, now_us, &out);
		check_sent(0);
		CHECK(out.count > 0 || mavlink_endpoint_deadline_us(&endpoint) > now_us);
		CHECK(++steps < 100);
	}
	check_servos();
}

static void heat(struct script *script)
{
	const uint8_t choice = take(script);
	const struct thermal_report report = {
		.state = (enum thermal_state)(choice % 3),
		.sensor = choice & 0x40 ? THERMAL_SENSOR_FAILED : THERMAL_SENSOR_OK,
		.fault = choice & 0x40 ? THERMAL_FAULT_STUCK : THERMAL_FAULT_NONE,
		.flags = choice % 3,
		.temp_mdegc = choice * 1000,
		.temp_valid = (choice & 0x40) == 0,
	};

	pharos_device_report_heat(&device, now_us, 0, &report);
	settle();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct script script = {data, data + size};

	start();
	while (script.at < script.end) {
		const uint8_t op = take(&script) % 15;

		if (op < 4) {
			raw(&script, op);
		} else if (op < 8) {
			message(&script, (uint8_t)(op - 4));
		} else if (op == 8) {
			time_moves(&script);
		} else if (op == 9) {
			heat(&script);
		} else if (op == 11) {
			configure(&script);
		} else if (op == 12) {
			signed_message(&script);
		} else if (op == 13) {
			setup(&script);
		} else if (op == 14) {
			compare_framers(&script);
		} else {
			struct mavlink_frame frame;

			for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
				while (mavlink_framer_idle(&framers[link], &frame)) {
					arrive(link, frame.bytes, frame.length);
				}
			}
		}
	}
	return 0;
}
