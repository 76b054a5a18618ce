/* SPDX-License-Identifier: Apache-2.0 */
/* The node's services. Specs: the uavcan.protocol types; dronecan.md, "Node". */
#include "device.h"

/* Zephyr's minimal C library has neither. */
#define NAN      __builtin_nanf("")
#define INFINITY __builtin_inff()

static struct dronecan_transfer heard;

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	device_start(NODE, false);
}

ZTEST_SUITE(dronecan_node, NULL, NULL, before, NULL, NULL);

/* --- NodeStatus ----------------------------------------------------------------------------- */

static void report(int64_t now_us, uint32_t limit_ppm, uint32_t flags, bool enable)
{
	struct illuminator *const illuminator = &core.lamps[0].illuminator;

	memset(illuminator, 0, sizeof(*illuminator));
	illuminator->thermal.limit_ppm = limit_ppm;
	illuminator->thermal.flags = flags;
	illuminator->thermal.temp_valid = true;
	illuminator->thermal.temp_mdegc = 26850; /* 300.0 K */
	illuminator->settings.enable = enable;
	dronecan_endpoint_report(&device, now_us);
}

static const uint8_t *status_at(int64_t now_us)
{
	device_step(now_us);
	for (size_t i = 0; i < device_bus.count; i++) {
		if (device_bus.frames[i].id == 0x18015544) { /* dronecan.md, "Golden frames" */
			return device_bus.frames[i].data;
		}
	}
	return NULL;
}

ZTEST(dronecan_node, test_node_status_is_the_golden_frame)
{
	/* Uptime 1 s, all OK. */
	static const uint8_t golden[] = {0x01, 0, 0, 0, 0, 0, 0, 0xC0};

	report(0, PPM_ONE, 0, false);
	device.node.status_us = SECOND;
	const uint8_t *data = status_at(SECOND);

	zassert_not_null(data);
	zassert_mem_equal(data, golden, sizeof(golden));
}

ZTEST(dronecan_node, test_node_status_comes_each_second_without_drift)
{
	int64_t now_us = 0;

	for (int64_t second = 0; second < 100; second++) {
		zassert_equal(dronecan_node_deadline_us(&device.node), second * SECOND);
		now_us = second * SECOND + (second % 7) * MS; /* called late now and then */
		zassert_not_null(status_at(now_us), "second %d", (int)second);
		zassert_is_null(status_at(now_us + 900 * MS));
	}
}

ZTEST(dronecan_node, test_mode_is_initialization_until_the_first_report)
{
	zassert_equal(status_at(0)[4], DRONECAN_NODE_STATUS_MODE_INITIALIZATION << 3);
	report(10 * MS, PPM_ONE, 0, false);
	zassert_equal(status_at(10 * MS)[4], DRONECAN_NODE_STATUS_MODE_OPERATIONAL);
}

/* Autopilots refuse to arm while health is not OK: throttling must not show there. */
ZTEST(dronecan_node, test_throttling_is_vendor_code_not_health)
{
	report(0, PPM_ONE, 0, true);
	status_at(0);
	report(SECOND / 2, PPM_ONE / 2, THERMAL_FLAG_THROTTLING, true);
	const uint8_t *data = status_at(SECOND);

	zassert_not_null(data);
	zassert_equal(data[4], 0, "health, mode");
	zassert_equal(data[5] | (data[6] << 8), THERMAL_FLAG_THROTTLING);
}

ZTEST(dronecan_node, test_a_lamp_that_may_not_be_lit_is_a_health_error_at_once)
{
	report(0, PPM_ONE, 0, true);
	status_at(0);
	report(SECOND / 2, 0, THERMAL_FLAG_SHUTDOWN, true);
	const uint8_t *data = status_at(SECOND / 2);

	zassert_not_null(data, "not after the rest of the second");
	zassert_equal(data[4], DRONECAN_NODE_STATUS_HEALTH_ERROR << 6);
}

/* --- services ------------------------------------------------------------------------------- */

ZTEST(dronecan_node, test_get_node_info)
{
	/* GetNodeInfo 10 -> 68, transfer id 3 (dronecan.md, "Golden frames"). */
	const struct dronecan_frame golden = FRAME(0x1401C48A, 0xC3);
	static const struct dronecan_subscription info[] = {
		{.type = &dronecan_get_node_info_type, .kind = DRONECAN_RESPONSE}};
	struct dronecan_get_node_info_response response;

	dronecan_transport_init(&tool, info, 1, TOOL, false, 1);
	dronecan_endpoint_receive(&device, 5 * SECOND, &golden, &device_out);
	device_frames(5 * SECOND);
	zassert_true(tool_hears(5 * SECOND, &dronecan_get_node_info_type, &heard));
	zassert_equal(heard.id, 3);
	zassert_equal(heard.priority, 20);
	zassert_true(
		dronecan_get_node_info_response_decode(&response, true, heard.data, heard.size));
	zassert_equal(response.status.uptime_sec, 5);
	zassert_equal(response.software_version.major, 1);
	zassert_equal(response.software_version.minor, 2);
	zassert_equal(response.software_version.vcs_commit, 0xDEADBEEF);
	zassert_equal(response.software_version.optional_field_flags, 1);
	zassert_equal(response.hardware_version.major, 3);
	zassert_mem_equal(response.hardware_version.unique_id, device_config.node.unique_id, 16);
	zassert_equal(response.name_len, 16);
	zassert_mem_equal(response.name, "org.pharos.light", 16);
}

ZTEST(dronecan_node, test_restart_needs_the_magic_number)
{
	static const uint8_t wrong[] = {0x1E, 0x1B, 0x55, 0xCE, 0xAD};
	static const uint8_t magic[] = {0x1E, 0x1B, 0x55, 0xCE, 0xAC}; /* ACCE551B1E */

	tool_sends(0, &dronecan_restart_node_type, DRONECAN_REQUEST, wrong, sizeof(wrong));
	zassert_true(tool_hears(0, &dronecan_restart_node_type, &heard));
	zassert_equal(heard.data[0], 0x00);
	device_step(SECOND);
	zassert_equal(device_out.node.count, 0);

	tool_sends(SECOND, &dronecan_restart_node_type, DRONECAN_REQUEST, magic, sizeof(magic));
	zassert_equal(device_out.node.count, 0, "first the answer");
	zassert_true(tool_hears(SECOND, &dronecan_restart_node_type, &heard));
	zassert_equal(heard.data[0], 0x80);
	zassert_equal(dronecan_node_deadline_us(&device.node), SECOND + 50 * MS);
	device_step(SECOND + 50 * MS);
	zassert_equal(device_out.node.count, 1);
	zassert_equal(device_out.node.actions[0].kind, DRONECAN_NODE_RESTART);
}

ZTEST(dronecan_node, test_a_repeated_request_is_not_carried_out_twice)
{
	static const uint8_t save[7] = {0};
	struct bus bus;

	bus_send(&bus, &tool, 0, &dronecan_param_execute_opcode_type, DRONECAN_REQUEST, NODE, save,
	         sizeof(save));
	dronecan_endpoint_receive(&device, 0, &bus.frames[0], &device_out);
	zassert_equal(device_out.node.count, 1);
	dronecan_endpoint_receive(&device, 0, &bus.frames[0], &device_out);
	zassert_equal(device_out.node.count, 0);
}

ZTEST(dronecan_node, test_get_transport_stats)
{
	struct dronecan_get_transport_stats_response response;

	dronecan_node_set_bus_errors(&device.node, 0x123456789A);
	status_at(0);
	tool_sends(0, &dronecan_get_transport_stats_type, DRONECAN_REQUEST, NULL, 0);
	zassert_true(tool_hears(0, &dronecan_get_transport_stats_type, &heard));
	zassert_true(dronecan_get_transport_stats_response_decode(&response, true, heard.data,
	                                                          heard.size));
	/* Sent before: NodeStatus and hardpoint.Status. Received: the request. */
	zassert_equal(response.transfers_tx, 2);
	zassert_equal(response.transfers_rx, 1);
	zassert_equal(response.transfer_errors, 0);
	zassert_equal(response.can_iface_stats_len, 1);
	zassert_equal(response.can_iface_stats[0].frames_tx, 2);
	zassert_equal(response.can_iface_stats[0].frames_rx, 1);
	zassert_equal(response.can_iface_stats[0].errors, 0x123456789A);
}

ZTEST(dronecan_node, test_log_message_is_cut_to_its_type)
{
	static const char text[] = "0123456789012345678901234567890123456789012345678901234567890"
				   "1234567890123456789012345678901234567890";
	struct dronecan_debug_log_message message;

	zassert_true(dronecan_node_log(&device.node, 0, DRONECAN_DEBUG_LOG_LEVEL_WARNING, "thermal",
	                               text));
	device_frames(0);
	zassert_true(tool_hears(0, &dronecan_debug_log_message_type, &heard));
	zassert_true(dronecan_debug_log_message_decode(&message, true, heard.data, heard.size));
	zassert_equal(message.level.value, DRONECAN_DEBUG_LOG_LEVEL_WARNING);
	zassert_equal(message.source_len, 7);
	zassert_mem_equal(message.source, "thermal", 7);
	zassert_equal(message.text_len, 90);
	zassert_mem_equal(message.text, text, 90);
}

ZTEST(dronecan_node, test_malformed_requests_are_counted_and_not_answered)
{
	static const uint8_t few[] = {1, 2, 3};

	tool_sends(0, &dronecan_restart_node_type, DRONECAN_REQUEST, few, sizeof(few));
	tool_sends(0, &dronecan_param_execute_opcode_type, DRONECAN_REQUEST, few, sizeof(few));
	tool_sends(0, &dronecan_param_get_set_type, DRONECAN_REQUEST, few, 1);
	zassert_equal(device.node.stats.malformed, 3);
	zassert_equal(device_bus.count, 0);
}

/* --- parameters ----------------------------------------------------------------------------- */

static struct dronecan_param_get_set_response
get_set(bool fd, const struct dronecan_param_get_set_request *r)
{
	struct dronecan_param_get_set_response response;
	uint8_t data[DRONECAN_PARAM_GET_SET_REQUEST_MAX_SIZE];
	size_t size;

	zassert_true(dronecan_param_get_set_request_encode(r, !fd, data, sizeof(data), &size));
	tool_sends(0, &dronecan_param_get_set_type, DRONECAN_REQUEST, data, size);
	zassert_true(tool_hears(0, &dronecan_param_get_set_type, &heard));
	zassert_equal(heard.fd, fd);
	zassert_true(
		dronecan_param_get_set_response_decode(&response, !fd, heard.data, heard.size));
	return response;
}

static struct dronecan_param_get_set_request named(const char *name)
{
	struct dronecan_param_get_set_request request;

	memset(&request, 0, sizeof(request));
	request.name_len = (uint8_t)strlen(name);
	memcpy(request.name, name, strlen(name));
	return request;
}

static void assert_real(const struct dronecan_param_get_set_response *response,
                        const struct param_info *info, int32_t value)
{
	static const double scales[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};
	const double scale = scales[info->decimals];

	zassert_equal(response->value.tag, DRONECAN_PARAM_VALUE_REAL_VALUE);
	zassert_equal(response->value.real_value, (float)(value / scale), "%s", info->name);
	zassert_equal(response->default_value.real_value, (float)(info->fallback / scale));
	zassert_equal(response->min_value.tag, DRONECAN_PARAM_NUMERIC_VALUE_REAL_VALUE);
	zassert_equal(response->min_value.real_value, (float)(info->min / scale));
	zassert_equal(response->max_value.real_value, (float)(info->max / scale));
}

ZTEST(dronecan_node, test_params_are_read_by_index_until_an_empty_one)
{
	struct dronecan_param_get_set_request request;

	memset(&request, 0, sizeof(request));
	for (uint16_t i = 0; i <= PARAM_COUNT; i++) {
		request.index = i;
		const struct dronecan_param_get_set_response response = get_set(false, &request);
		const struct param_info *info = params_info(i);

		if (info == NULL) {
			zassert_equal(i, PARAM_COUNT);
			zassert_equal(response.name_len, 0);
			zassert_equal(response.value.tag, DRONECAN_PARAM_VALUE_EMPTY);
			break;
		}
		zassert_equal(response.name_len, strlen(info->name));
		zassert_mem_equal(response.name, info->name, response.name_len);
		if (info->decimals > 0) {
			assert_real(&response, info, core.params.values[i]);
			continue;
		}
		zassert_equal(response.value.tag, DRONECAN_PARAM_VALUE_INTEGER_VALUE);
		zassert_equal(response.value.integer_value, core.params.values[i]);
		zassert_equal(response.default_value.integer_value, info->fallback);
		zassert_equal(response.min_value.integer_value, info->min);
		zassert_equal(response.max_value.integer_value, info->max);
	}
}

ZTEST(dronecan_node, test_a_temperature_is_told_in_degrees)
{
	const struct dronecan_param_get_set_request request = named("THR_SHUTDOWN");
	const struct dronecan_param_get_set_response response = get_set(false, &request);

	zassert_equal(response.value.real_value, 100.0f);
	zassert_equal(response.min_value.real_value, -40.0f);
	zassert_equal(response.max_value.real_value, 150.0f);
}

static void set_by_name(bool fd)
{
	struct dronecan_param_get_set_request request = named("LGT_LOSS");
	struct dronecan_param_get_set_response response;

	request.index = 3; /* a name counts before an index */
	request.value.tag = DRONECAN_PARAM_VALUE_INTEGER_VALUE;
	request.value.integer_value = 5; /* whole seconds */
	response = get_set(fd, &request);
	zassert_equal(response.value.real_value, 5.0f);
	zassert_equal(core.params.values[PARAM_LGT_LOSS], 5000);
	device_effects();
	zassert_equal(param_set_take(&effects.params), PARAM_LGT_LOSS);
	zassert_true(param_set_is_empty(&effects.params));
}

ZTEST(dronecan_node, test_a_param_is_set_by_name)
{
	set_by_name(false);
}

ZTEST(dronecan_node, test_a_param_is_set_by_name_over_fd)
{
	device_start(NODE, true);
	set_by_name(true);
}

ZTEST(dronecan_node, test_refused_sets_answer_with_the_value_in_force)
{
	struct dronecan_param_get_set_request request = named("LGT_CURVE"); /* 0 or 1 */
	const int32_t value = core.params.values[PARAM_LGT_CURVE];
	static const int64_t out_of_range[] = {2, -1, INT64_MAX, INT64_MIN, 1ll << 32};

	request.value.tag = DRONECAN_PARAM_VALUE_INTEGER_VALUE;
	for (size_t i = 0; i < ARRAY_SIZE(out_of_range); i++) {
		request.value.integer_value = out_of_range[i];
		zassert_equal(get_set(false, &request).value.integer_value, value);
		zassert_false(pharos_device_take(&core, &effects));
	}
	static const float no_whole[] = {0.5f, -0.5f, NAN, INFINITY, 2147483648.0f, 2.0f};

	request.value.tag = DRONECAN_PARAM_VALUE_REAL_VALUE;
	for (size_t i = 0; i < ARRAY_SIZE(no_whole); i++) {
		request.value.real_value = no_whole[i];
		zassert_equal(get_set(false, &request).value.integer_value, value);
	}
	request.value.tag = DRONECAN_PARAM_VALUE_STRING_VALUE;
	request.value.string_value_len = 1;
	zassert_equal(get_set(false, &request).value.integer_value, value);
	zassert_equal(device.node.stats.params_refused, 12);
}

ZTEST(dronecan_node, test_a_switch_may_be_sent_as_a_boolean)
{
	struct dronecan_param_get_set_request request = named("LGT_CURVE"); /* 0 or 1 */

	request.value.tag = DRONECAN_PARAM_VALUE_BOOLEAN_VALUE;
	request.value.boolean_value = 1;
	zassert_equal(get_set(false, &request).value.integer_value, 1);
	request.value.boolean_value = 0;
	zassert_equal(get_set(false, &request).value.integer_value, 0);
	zassert_equal(device.node.stats.params_refused, 0);
	request.value.boolean_value = 2; /* neither */
	zassert_equal(get_set(false, &request).value.integer_value, 0);
	zassert_equal(device.node.stats.params_refused, 1);
}

/* Tools that have one kind of number send it so. */
ZTEST(dronecan_node, test_whole_real_values_are_taken)
{
	struct dronecan_param_get_set_request request = named("LGT_FALLBACK");

	request.value.tag = DRONECAN_PARAM_VALUE_REAL_VALUE;
	request.value.real_value = 2.0f;
	zassert_equal(get_set(false, &request).value.integer_value, 2);
	zassert_equal(core.params.values[PARAM_LGT_FALLBACK], 2);
	zassert_equal(device.node.stats.params_refused, 0);
}

ZTEST(dronecan_node, test_a_real_value_becomes_the_nearest_step)
{
	struct dronecan_param_get_set_request request = named("LGT_LOSS");

	request.value.tag = DRONECAN_PARAM_VALUE_REAL_VALUE;
	request.value.real_value = 4.0004f;
	zassert_equal(get_set(false, &request).value.real_value, 4.0f);
	request.value.real_value = 4.5f;
	zassert_equal(get_set(false, &request).value.real_value, 4.5f);
	zassert_equal(core.params.values[PARAM_LGT_LOSS], 4500);
	zassert_equal(device.node.stats.params_refused, 0);
}

ZTEST(dronecan_node, test_an_unknown_name_answers_empty)
{
	const struct dronecan_param_get_set_request request = named("NO_SUCH_PARAM");
	const struct dronecan_param_get_set_response response = get_set(false, &request);

	zassert_equal(response.name_len, 0);
	zassert_equal(response.value.tag, DRONECAN_PARAM_VALUE_EMPTY);
}

static bool opcode(uint8_t code)
{
	struct dronecan_param_execute_opcode_response response;
	const uint8_t data[7] = {code};

	tool_sends(0, &dronecan_param_execute_opcode_type, DRONECAN_REQUEST, data, sizeof(data));
	zassert_true(tool_hears(0, &dronecan_param_execute_opcode_type, &heard));
	zassert_true(dronecan_param_execute_opcode_response_decode(&response, true, heard.data,
	                                                           heard.size));
	return response.ok;
}

ZTEST(dronecan_node, test_execute_opcode_saves_and_erases)
{
	const int32_t fallback = params_info(PARAM_LGT_LOSS)->fallback;

	zassert_true(opcode(DRONECAN_PARAM_EXECUTE_OPCODE_OPCODE_SAVE));
	zassert_equal(device_out.node.count, 1);
	zassert_equal(device_out.node.actions[0].kind, DRONECAN_NODE_SAVE);

	core.params.values[PARAM_LGT_LOSS] = fallback + 7;
	zassert_true(opcode(DRONECAN_PARAM_EXECUTE_OPCODE_OPCODE_ERASE));
	zassert_equal(device_out.node.count, 1);
	zassert_equal(device_out.node.actions[0].kind, DRONECAN_NODE_ERASE);
	device_effects();
	zassert_equal(param_set_take(&effects.params), PARAM_LGT_LOSS);
	zassert_true(param_set_is_empty(&effects.params));
	zassert_equal(core.params.values[PARAM_LGT_LOSS], fallback);

	zassert_false(opcode(2));
	zassert_equal(device_out.node.count, 0);
}

/* On FD, a classic request is answered in classic frames: its asker may know no others. */
ZTEST(dronecan_node, test_answers_are_fd_when_the_request_was)
{
	device_start(NODE, true);
	tool_sends(0, &dronecan_get_transport_stats_type, DRONECAN_REQUEST, NULL, 0);
	zassert_true(device_bus.frames[0].fd);
	tool.fd = false;
	tool_sends(0, &dronecan_get_transport_stats_type, DRONECAN_REQUEST, NULL, 0);
	zassert_true(device_bus.count > 1);
	zassert_false(device_bus.frames[0].fd);
}

/* --- dynamic node id ------------------------------------------------------------------------ */

static void allocator_says(int64_t now_us, uint8_t node_id, uint8_t size)
{
	uint8_t data[17] = {(uint8_t)(node_id << 1)};

	memcpy(&data[1], device_config.node.unique_id, size);
	tool_sends(now_us, &dronecan_dynamic_node_id_allocation_type, DRONECAN_MESSAGE, data,
	           1u + size);
}

/* The device's next frame, at its own time. */
static struct dronecan_frame next_request(int64_t *now_us)
{
	*now_us = dronecan_node_deadline_us(&device.node);
	device_step(*now_us);
	zassert_equal(device_bus.count, 1);
	return device_bus.frames[0];
}

ZTEST(dronecan_node, test_allocation_in_three_parts)
{
	/* First byte: preferred << 1 | first; then 6 + 6 + 4 bytes of the unique id. */
	static const uint8_t first[] = {0x01, 0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0xC0};
	static const uint8_t second[] = {0x00, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0xC1};
	static const uint8_t third[] = {0x00, 0x31, 0x32, 0x33, 0x34, 0xC2};
	struct dronecan_frame frame;
	int64_t now_us;
	int64_t answered_us;

	device_start(0, false);
	frame = next_request(&now_us);
	zassert_between_inclusive(now_us, 600 * MS, 1000 * MS);
	zassert_equal(frame.id & 0x1F0003FFu, 0x18000100u);
	zassert_equal(frame.size, sizeof(first));
	zassert_mem_equal(frame.data, first, sizeof(first));

	answered_us = now_us + 10 * MS;
	allocator_says(answered_us, 0, 6);
	frame = next_request(&now_us);
	zassert_between_inclusive(now_us - answered_us, 0, 400 * MS);
	zassert_mem_equal(frame.data, second, sizeof(second));

	answered_us = now_us + 10 * MS;
	allocator_says(answered_us, 0, 12);
	frame = next_request(&now_us);
	zassert_between_inclusive(now_us - answered_us, 0, 400 * MS);
	zassert_equal(frame.size, sizeof(third));
	zassert_mem_equal(frame.data, third, sizeof(third));

	allocator_says(now_us + 10 * MS, 125, 16);
	zassert_equal(device_out.node.count, 1);
	zassert_equal(device_out.node.actions[0].kind, DRONECAN_NODE_ID_ALLOCATED);
	zassert_equal(device_out.node.actions[0].node_id, 125);
	device_step(now_us + 10 * MS);
	zassert_true(device_bus.count >= 1);
	zassert_equal(device_bus.frames[0].id, 0x1801557D, "NodeStatus as 125 at once");
}

ZTEST(dronecan_node, test_requests_go_on_every_600_to_1000_ms_at_random)
{
	int64_t before_us = 0;
	int64_t first_gap_us = 0;
	bool differ = false;

	device_start(0, false);
	for (int i = 0; i < 200; i++) {
		int64_t now_us;

		next_request(&now_us);
		zassert_between_inclusive(now_us - before_us, 600 * MS, 1000 * MS);
		differ = differ || (i > 0 && now_us - before_us != first_gap_us);
		first_gap_us = (i == 0) ? now_us : first_gap_us;
		before_us = now_us;
	}
	zassert_true(differ);
}

/* Rule D: another Allocation message takes the follow-up back. Rule C: the timer restarts. */
ZTEST(dronecan_node, test_another_nodes_request_takes_the_follow_up_back)
{
	const struct dronecan_frame other =
		FRAME(0x18ABC100, 0x01, 0x77, 0x77, 0x77, 0x77, 0x77, 0x77, 0xC0);
	struct dronecan_frame frame;
	int64_t now_us;

	device_start(0, false);
	next_request(&now_us);
	allocator_says(now_us, 0, 6);
	zassert_true(dronecan_node_deadline_us(&device.node) <= now_us + 400 * MS);
	dronecan_endpoint_receive(&device, now_us, &other, &device_out);
	const int64_t restarted_us = now_us;

	frame = next_request(&now_us);
	zassert_between_inclusive(now_us - restarted_us, 600 * MS, 1000 * MS);
	zassert_equal(frame.data[0], 0x01, "from the start again");
}

/* Only an allocator has a node id: another node's unique id may begin like ours. */
ZTEST(dronecan_node, test_an_anonymous_message_is_no_answer)
{
	const struct dronecan_frame other =
		FRAME(0x18ABC100, 0x01, 0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0xC0);
	int64_t now_us;

	device_start(0, false);
	next_request(&now_us);
	dronecan_endpoint_receive(&device, now_us, &other, &device_out);
	zassert_true(dronecan_node_deadline_us(&device.node) >= now_us + 600 * MS);
}

/* The allocator forgets after 500 ms: whoever comes later than that begins anew. */
ZTEST(dronecan_node, test_a_late_follow_up_begins_anew)
{
	int64_t now_us;

	device_start(0, false);
	next_request(&now_us);
	allocator_says(now_us, 0, 6);
	device_step(now_us + SECOND);
	zassert_equal(device_bus.count, 1);
	zassert_equal(device_bus.frames[0].data[0], 0x01);
	zassert_true(dronecan_node_deadline_us(&device.node) > now_us + SECOND);
}

ZTEST(dronecan_node, test_an_answer_to_somebody_else_is_not_ours)
{
	static const uint8_t other[] = {125 << 1, 1,  2,  3,  4,  5,  6,  7, 8,
	                                9,        10, 11, 12, 13, 14, 15, 16};
	int64_t now_us;

	device_start(0, false);
	next_request(&now_us);
	tool_sends(now_us, &dronecan_dynamic_node_id_allocation_type, DRONECAN_MESSAGE, other,
	           sizeof(other));
	zassert_equal(device_out.node.count, 0);
	zassert_equal(device.transport.node_id, 0);
}

ZTEST(dronecan_node, test_anonymous_says_nothing_but_its_request)
{
	device_start(0, false);
	report(0, PPM_ONE, 0, true);
	zassert_false(dronecan_node_log(&device.node, 0, 0, "a", "b"));
	for (int64_t now_us = 0; now_us < 5 * SECOND; now_us += 50 * MS) {
		device_step(now_us);
		for (size_t i = 0; i < device_bus.count; i++) {
			zassert_equal(device_bus.frames[i].id & 0x3FF, 0x100);
		}
		zassert_true(dronecan_endpoint_deadline_us(&device) > now_us);
	}
}

ZTEST(dronecan_node, test_allocation_is_asked_for_in_classic_frames_on_an_fd_bus)
{
	int64_t now_us;

	device_start(0, true);
	zassert_false(next_request(&now_us).fd);
}
