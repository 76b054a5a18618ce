/* SPDX-License-Identifier: Apache-2.0 */
#include "fixture.h"

struct pharos_device device;
struct illuminator *const light = &device.lamps[0].illuminator;
struct arbiter *const arbiter = &device.lamps[0].arbiter;
struct params *const device_params = &device.params;
struct device_effects effects;
struct mavlink_illuminator service;
struct mavlink_endpoint endpoint;
struct mavlink_outbox out;
int64_t now_us;

static uint8_t ground_sequence;

static const uint8_t general[] = {'{', '}'};

static const struct mavlink_file general_file = {"g.json", general, sizeof(general), 0x12345678};

static const struct mavlink_files general_files = {&general_file, 1};

static const struct mavlink_identity identity = {
	.vendor_name = "Pharos",
	.model_name = "Light",
	.software_version = "1.2.3",
	.hardware_version = "4.5.6",
	.serial_number = "SN-0042",
	.files = &general_files,
	.time_manufacture_s = 1700000000,
	.version_code = 0x010203FF,
};

void fixture_before(void *unused)
{
	const struct illuminator_config light_config = {
		.min_period_us = 10000,
		.max_period_us = 10000000,
		.curve = ILLUMINATOR_CURVE_LINEAR,
	};
	const struct device_config device_config = {.gimbal = true};
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 0x03};

	(void)unused;
	now_us = 0;
	ground_sequence = 0;
	params_init(device_params);
	device_params->values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&device, now_us, &device_config);
	params_init(device_params);
	illuminator_init(light, &light_config);
	mavlink_illuminator_init(&service, &device, 0, &identity);
	mavlink_endpoint_init(&endpoint, &config);
	mavlink_endpoint_add(&endpoint, now_us, 243, &mavlink_illuminator_profile, &service);
	memset(&out, 0xA5, sizeof(out));
}

void settle(void)
{
	memset(&effects, 0, sizeof(effects));
	if (pharos_device_take(&device, &effects)) {
		mavlink_endpoint_tell(&endpoint, now_us, &effects);
	}
}

void receive(uint8_t link, const uint8_t *bytes, size_t length)
{
	mavlink_endpoint_receive(&endpoint, now_us, link, bytes, length, &out);
	settle();
}

void receive_message(uint8_t link, const struct mavlink_kind *kind, const void *payload)
{
	const struct mavlink_sender ground = {
		.version = 2, .sequence = ground_sequence++, .system_id = 255, .component_id = 190};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(link, bytes, mavlink_frame_build(bytes, &ground, kind, payload));
}

void receive_long(uint8_t link, uint8_t system, uint8_t component, uint16_t id,
                  struct command_params params)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t wire = {
		.param1 = params.p[0],
		.param2 = params.p[1],
		.param3 = params.p[2],
		.param4 = params.p[3],
		.param5 = params.p[4],
		.param6 = params.p[5],
		.param7 = params.p[6],
		.command = id,
		.target_system = system,
		.target_component = component,
	};

	receive_message(link, &kind, &wire);
}

uint8_t command(uint16_t id, struct command_params params)
{
	mavlink_command_ack_t ack;

	receive_long(0, 1, 243, id, params);
	zassert_true(out.count >= 1, "command %u is not answered", id);
	sent_payload(0, 77, &ack, sizeof(ack)); /* COMMAND_ACK is 77 */
	zassert_equal(out.frames[0].link, 0);
	zassert_equal(ack.command, id);
	zassert_equal(ack.target_system, 255);
	zassert_equal(ack.target_component, 190);
	for (uint16_t i = 1; i < out.count; i++) {
		zassert_not_equal(sent(i).message_id, 77, "a second acknowledgement");
	}
	return ack.result;
}

static void count(struct tally *tally, uint16_t i)
{
	const struct mavlink_frame frame = sent(i);
	const uint8_t link = out.frames[i].link;

	switch (frame.message_id) {
	case 0: /* HEARTBEAT */
		tally->heartbeats[link]++;
		sent_payload(i, 0, &tally->last_heartbeat, sizeof(tally->last_heartbeat));
		break;
	case 440: /* ILLUMINATOR_STATUS */
		tally->statuses[link]++;
		sent_payload(i, 440, &tally->last_status, sizeof(tally->last_status));
		break;
	case 253: /* STATUSTEXT */
		tally->texts[link]++;
		sent_payload(i, 253, &tally->last_text, sizeof(tally->last_text));
		break;
	default:
		tally->others[link]++;
		break;
	}
}

struct tally run_until(int64_t until_us)
{
	struct tally tally = {0};

	while (mavlink_endpoint_deadline_us(&endpoint) <= until_us) {
		const int64_t due_us = mavlink_endpoint_deadline_us(&endpoint);

		now_us = due_us > now_us ? due_us : now_us;
		mavlink_endpoint_step(&endpoint, now_us, &out);
		zassert_true(out.count > 0 || mavlink_endpoint_deadline_us(&endpoint) > now_us,
		             "a step that does nothing and is due again");
		for (uint16_t i = 0; i < out.count; i++) {
			count(&tally, i);
		}
	}
	now_us = until_us;
	return tally;
}

struct mavlink_frame sent(uint16_t i)
{
	struct mavlink_frame frame = {0};

	zassert_true(i < out.count, "only %u frames sent", out.count);
	zassert_true(
		mavlink_frame_view(&out.bytes[out.frames[i].offset], out.frames[i].length, &frame));
	return frame;
}

void sent_payload(uint16_t i, uint32_t id, void *payload, size_t size)
{
	const struct mavlink_frame frame = sent(i);

	zassert_equal(frame.message_id, id, "message %u, not %u", (unsigned int)frame.message_id,
	              (unsigned int)id);
	zassert_equal(frame.system_id, 1);
	zassert_equal(frame.component_id, 243);
	mavlink_frame_payload(&frame, payload, size);
}

void assert_sent(uint16_t i, uint8_t link, const uint8_t *bytes, size_t length)
{
	zassert_true(i < out.count, "only %u frames sent", out.count);
	zassert_equal(out.frames[i].link, link);
	zassert_equal(out.frames[i].length, length, "%u bytes, not %u", out.frames[i].length,
	              (unsigned int)length);
	zassert_mem_equal(&out.bytes[out.frames[i].offset], bytes, length);
}

mavlink_illuminator_status_t status_now(void)
{
	mavlink_illuminator_status_t status;

	zassert_equal(COMMAND(512, 440), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 2);
	sent_payload(1, 440, &status, sizeof(status));
	return status;
}

void thermal_report(enum thermal_state state, enum thermal_fault fault, int32_t temp_mdegc)
{
	const bool failed = fault != THERMAL_FAULT_NONE;
	uint32_t flags = failed ? THERMAL_FLAG_THERMISTOR : 0;

	flags |= state == THERMAL_STATE_THROTTLING ? THERMAL_FLAG_THROTTLING : 0;
	flags |= state == THERMAL_STATE_SHUTDOWN ? THERMAL_FLAG_SHUTDOWN : 0;

	const struct thermal_report report = {
		.state = state,
		.sensor = failed ? THERMAL_SENSOR_FAILED : THERMAL_SENSOR_OK,
		.fault = fault,
		.flags = flags,
		.limit_ppm = 500000,
		.temp_mdegc = failed ? 0 : temp_mdegc,
		.temp_valid = !failed,
	};

	pharos_device_report_heat(&device, now_us, 0, &report);
	settle();
}
