/* SPDX-License-Identifier: Apache-2.0 */
/* Another node with our node id: what counts as one, and what is done. */
#include "device.h"

/* NodeStatus of node 68 and of 69; GetNodeInfo 68 -> 68, and 10 -> 68. */
#define STATUS       0x18015544
#define OTHER_STATUS 0x18015545
#define ASK          0x1E01C4C4
#define TOOLS        0x1401C48A

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	device_start(NODE, false);
	core.lamps[0].illuminator.thermal.limit_ppm = PPM_ONE;
}

ZTEST_SUITE(dronecan_clash, NULL, NULL, before, NULL, NULL);

static void hears(int64_t now_us, const struct dronecan_frame *frame)
{
	dronecan_endpoint_receive(&device, now_us, frame, &device_out);
}

static void hears_status(int64_t now_us, uint32_t id, uint8_t uptime_s)
{
	static uint8_t transfer_id;
	const struct dronecan_frame frame =
		FRAME(id, uptime_s, 0, 0, 0, 0, 0, 0, (uint8_t)(0xC0 | transfer_id));

	transfer_id = (transfer_id + 1) & 31;
	hears(now_us, &frame);
}

/* The other node's answer to GetNodeInfo, from our id to our id. */
static void hears_info(int64_t now_us, const uint8_t unique_id[16])
{
	static struct dronecan_transport twin;
	struct dronecan_get_node_info_response info = {.name_len = 4, .name = "twin"};
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
	size_t size;
	struct bus bus;

	memcpy(info.hardware_version.unique_id, unique_id, 16);
	zassert_true(
		dronecan_get_node_info_response_encode(&info, true, data, sizeof(data), &size));
	dronecan_transport_init(&twin, tool_subscriptions, 1, NODE, false, 7);
	bus_send(&bus, &twin, now_us, &dronecan_get_node_info_type, DRONECAN_RESPONSE, NODE, data,
	         size);
	for (size_t i = 0; i < bus.count; i++) {
		hears(now_us, &bus.frames[i]);
	}
}

/* Whether a frame with that id is sent until then. */
static bool sends(int64_t until_us, uint32_t id)
{
	bool found = false;

	for (;;) {
		const int64_t due_us = dronecan_endpoint_deadline_us(&device);

		if (due_us > until_us) {
			return found;
		}
		device_step(due_us);
		for (size_t i = 0; i < device_bus.count; i++) {
			found = found || device_bus.frames[i].id == id;
		}
	}
}

static uint8_t health(void)
{
	dronecan_endpoint_report(&device, 0);
	return device.node.condition.health;
}

ZTEST(dronecan_clash, test_a_status_with_another_uptime_is_a_clash)
{
	hears_status(20 * SECOND, OTHER_STATUS, 3);
	zassert_false(device.node.clash.on, "another id");
	hears_status(20 * SECOND, STATUS, 17);
	zassert_true(device.node.clash.on);
	zassert_equal(health(), DRONECAN_NODE_STATUS_HEALTH_WARNING);
	before(NULL);
	hears_status(20 * SECOND, STATUS, 21);
	zassert_true(device.node.clash.on, "older than we are");
}

/* A bridge sends our own frames back, somewhat later. */
ZTEST(dronecan_clash, test_an_echo_is_no_clash)
{
	for (uint8_t late_s = 0; late_s <= 2; late_s++) {
		hears_status(20 * SECOND, STATUS, (uint8_t)(20 - late_s));
	}
	hears_info(20 * SECOND, device_config.node.unique_id);
	zassert_false(device.node.clash.on);
	zassert_equal(health(), DRONECAN_NODE_STATUS_HEALTH_OK);
}

ZTEST(dronecan_clash, test_who_has_our_id_is_asked_until_it_is_named)
{
	static const uint8_t other[16] = {0xAB, [15] = 0xCD};

	zassert_false(sends(5 * SECOND, ASK));
	for (uint8_t second = 5; second < 8; second++) { /* as old as we are */
		hears_status(second * SECOND, STATUS, second);
		zassert_true(sends((second + 1) * SECOND - 1, ASK), "second %d", second);
	}
	zassert_false(device.node.clash.on);
	hears_info(8 * SECOND, other);
	zassert_true(device.node.clash.on);
	zassert_true(device.node.clash.is_named);
	zassert_mem_equal(device.node.clash.unique_id, other, 16);
	hears_status(9 * SECOND, STATUS, 9);
	zassert_false(sends(10 * SECOND, ASK));
}

ZTEST(dronecan_clash, test_many_statuses_are_one_question_a_second)
{
	uint32_t asked = 0;

	for (int64_t now_us = 20 * SECOND; now_us < 30 * SECOND; now_us += 10 * MS) {
		hears_status(now_us, STATUS, 1);
		asked += sends(now_us + 10 * MS - 1, ASK) ? 1 : 0;
	}
	zassert_between_inclusive(asked, 6, 12);
}

ZTEST(dronecan_clash, test_it_is_over_after_ten_silent_seconds)
{
	hears_status(20 * SECOND, STATUS, 1);
	hears_status(25 * SECOND, STATUS, 25);
	(void)sends(35 * SECOND - 1, ASK);
	zassert_true(device.node.clash.on, "any status from our id is the other's now");
	(void)sends(35 * SECOND, ASK);
	zassert_false(device.node.clash.on);
	zassert_equal(health(), DRONECAN_NODE_STATUS_HEALTH_OK);
}

/* The other one asks us as we ask it. */
ZTEST(dronecan_clash, test_a_question_from_our_own_id_is_answered)
{
	const struct dronecan_frame question = FRAME(ASK, 0xC3);

	hears(5 * SECOND, &question);
	device_frames(5 * SECOND);
	zassert_true(device_bus.count > 1);
	zassert_equal(device_bus.frames[0].id, 0x1E014444 | 0x80, "68 -> 68, a response");
}

/* Two answers at once destroy each other. */
ZTEST(dronecan_clash, test_answers_come_at_random_times_while_it_lasts)
{
	const struct dronecan_frame question = FRAME(TOOLS, 0xC3);
	int64_t first_us = -1;
	bool differ = false;

	for (int64_t now_us = 20 * SECOND; now_us < 30 * SECOND; now_us += SECOND) {
		int64_t after_us = 0;

		hears_status(now_us, STATUS, 1);
		hears(now_us, &question);
		while (device.node.clash.answer_us != TIME_NEVER_US && after_us < SECOND) {
			after_us += 20 * MS;
			device_step(now_us + after_us);
		}
		zassert_true(after_us <= 320 * MS);
		differ = differ || (first_us >= 0 && after_us != first_us);
		first_us = after_us;
	}
	zassert_true(differ);
}

ZTEST(dronecan_clash, test_what_else_comes_from_our_id_is_refused)
{
	const struct dronecan_frame restart = FRAME(0x1405C4C4, 0x1E, 0x1B, 0x55, 0xCE, 0xAC, 0xC0);
	const struct dronecan_frame lights = FRAME(0x18043944, 0xFE, 0xFF, 0xFF, 0xC0);

	hears(SECOND, &restart);
	hears(SECOND, &lights);
	zassert_equal(device.node.stats.requests, 0);
	zassert_equal(device.lights.stats.commands, 0);
	zassert_equal(device.transport.stats.rx_own_id, 2);
}
