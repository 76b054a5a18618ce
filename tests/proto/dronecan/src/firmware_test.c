/* SPDX-License-Identifier: Apache-2.0 */
/* BeginFirmwareUpdate and file.Read against a server played by hand at node 10. */
#include "device.h"

static const struct dronecan_subscription server_subscriptions[] = {
	{.type = &dronecan_file_begin_firmware_update_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_file_read_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_node_status_type, .kind = DRONECAN_MESSAGE},
};

static uint8_t payload[DRONECAN_RX_PAYLOAD_MAX];

static void before(void *fixture)
{
	device_start(NODE, false);
	dronecan_transport_init(&tool, server_subscriptions, ARRAY_SIZE(server_subscriptions), TOOL,
	                        false, 1);
	device_step(0);
}

ZTEST_SUITE(dronecan_firmware, NULL, NULL, before, NULL, NULL);

/* The error in the answer, -1: no answer. */
static int begin(int64_t now_us, uint8_t server, const char *path)
{
	struct dronecan_file_begin_firmware_update_request request = {.source_node_id = server};
	struct dronecan_file_begin_firmware_update_response response;
	struct dronecan_transfer heard;
	size_t size;

	request.image_file_remote_path.path_len = (uint8_t)strlen(path);
	memcpy(request.image_file_remote_path.path, path, strlen(path));
	zassert_true(dronecan_file_begin_firmware_update_request_encode(&request, true, payload,
	                                                                sizeof(payload), &size));
	tool_sends(now_us, &dronecan_file_begin_firmware_update_type, DRONECAN_REQUEST, payload,
	           size);
	if (!tool_hears(now_us, &dronecan_file_begin_firmware_update_type, &heard)) {
		return -1;
	}
	zassert_true(dronecan_file_begin_firmware_update_response_decode(&response, true,
	                                                                 heard.data, heard.size));
	return response.error;
}

/* The read request that the device has just sent. */
static struct dronecan_transfer asked(int64_t now_us, uint64_t offset)
{
	struct dronecan_file_read_request request;
	struct dronecan_transfer heard;

	zassert_true(tool_hears(now_us, &dronecan_file_read_type, &heard));
	zassert_true(dronecan_file_read_request_decode(&request, true, heard.data, heard.size));
	zassert_equal(request.offset, offset);
	zassert_equal(request.path.path_len, 1);
	zassert_equal(request.path.path[0], 'f');
	return heard;
}

/* A response by hand: our own transport sends no payload as long as a block. */
static void answer(int64_t now_us, const struct dronecan_transfer *request, size_t count,
                   int16_t error)
{
	struct dronecan_file_read_response response = {.error.value = error,
	                                               .data_len = (uint16_t)count};
	uint8_t bytes[2 + DRONECAN_RX_PAYLOAD_MAX];
	struct dronecan_frame frame = {.id = 20u << 24 | 48u << 16 | NODE << 8 | 0x80 | TOOL};
	uint8_t tail = 0x80 | request->id; /* start */
	size_t at = 2;
	uint16_t crc;
	size_t size;

	memset(response.data, 0xAB, count);
	zassert_true(dronecan_file_read_response_encode(&response, true, bytes + 2,
	                                                sizeof(bytes) - 2, &size));
	crc = dronecan_crc(dronecan_file_read_type.crc_seed, bytes + 2, size);
	if (size > 7) {
		bytes[0] = (uint8_t)crc;
		bytes[1] = (uint8_t)(crc >> 8);
		size += 2;
		at = 0;
	}
	for (size_t end = at + size; at < end; tail = (tail ^ 0x20) & 0x3F) {
		frame.size = (uint8_t)MIN(7, end - at);
		memcpy(frame.data, bytes + at, frame.size);
		at += frame.size;
		tail |= at == end ? 0x40 : 0;
		frame.data[frame.size++] = tail;
		dronecan_endpoint_receive(&device, now_us, &frame, &device_out);
	}
	device_frames(now_us);
}

static struct dronecan_transfer next(int64_t now_us, uint64_t offset)
{
	dronecan_firmware_next(&device.firmware, now_us);
	device_frames(now_us);
	return asked(now_us, offset);
}

ZTEST(dronecan_firmware, test_blocks_come_in_order_and_a_short_one_is_the_last)
{
	struct dronecan_transfer request;

	zassert_equal(begin(1, TOOL, "f"), 0); /* ERROR_OK */
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_BEGIN);
	request = next(2, 0);
	answer(3, &request, 256, 0);
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_BLOCK);
	zassert_equal(device_out.firmware.size, 256);
	zassert_equal(device_out.firmware.data[255], 0xAB);
	zassert_false(device_out.firmware.is_last);
	request = next(4, 256);
	answer(5, &request, 0, 0);
	zassert_equal(device_out.firmware.size, 0);
	zassert_true(device_out.firmware.is_last);
	dronecan_firmware_stop(&device.firmware);
	zassert_equal(dronecan_firmware_deadline_us(&device.firmware), TIME_NEVER_US);
}

/* DSDL: "If this field is zero, the caller's Node ID will be used instead." */
ZTEST(dronecan_firmware, test_server_zero_is_the_asker)
{
	zassert_equal(begin(1, 0, "f"), 0);
	(void)next(2, 0);
	zassert_equal(device.firmware.server, TOOL);
}

ZTEST(dronecan_firmware, test_what_is_refused)
{
	zassert_equal(begin(1, 128, "f"), 255); /* ERROR_UNKNOWN: there is no node 128 */
	zassert_equal(begin(2, TOOL, ""), 255);
	zassert_equal(device.firmware.stats.refused, 2);
	zassert_equal(begin(3, TOOL, "f"), 0);
	zassert_equal(begin(4, TOOL, "g"), 2); /* ERROR_IN_PROGRESS */
	zassert_equal(device.firmware.stats.refused, 3);
	zassert_equal(begin(5, TOOL, "f"), 2); /* the same again, its answer may have been lost */
	zassert_equal(device.firmware.stats.refused, 3);
	zassert_equal(device.firmware.stats.begun, 1);

	dronecan_firmware_init(&device.firmware, &device.node, "no room");
	zassert_equal(begin(6, TOOL, "f"), 1); /* ERROR_INVALID_MODE */
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_NOTHING);
}

ZTEST(dronecan_firmware, test_a_request_is_repeated_each_second_ten_times_in_all)
{
	zassert_equal(begin(0, TOOL, "f"), 0);
	(void)next(0, 0);
	for (int64_t second = 1; second < 10; second++) {
		device_step(second * SECOND);
		(void)asked(second * SECOND, 0);
		zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_NOTHING);
	}
	device_step(10 * SECOND);
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_FAILED);
	zassert_equal(device_out.firmware.error, 0);
	zassert_equal(begin(11 * SECOND, TOOL, "f"), 0);
}

/* Taken for the answer, it would let the second one be taken for the next block. */
ZTEST(dronecan_firmware, test_a_late_answer_to_an_earlier_request_is_ignored)
{
	struct dronecan_transfer late;
	struct dronecan_transfer request;

	zassert_equal(begin(0, TOOL, "f"), 0);
	late = next(0, 0);
	device_step(SECOND);
	request = asked(SECOND, 0);
	zassert_not_equal(request.id, late.id);
	answer(SECOND + 1, &late, 256, 0);
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_NOTHING);
	zassert_equal(device.firmware.stats.ignored, 1);
	answer(SECOND + 2, &request, 256, 0);
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_BLOCK);
	request = next(SECOND + 3, 256);
	answer(SECOND + 5, &request, 10, 0);
	zassert_true(device_out.firmware.is_last);
}

ZTEST(dronecan_firmware, test_an_error_of_the_server_ends_it)
{
	struct dronecan_transfer request;

	zassert_equal(begin(0, TOOL, "f"), 0);
	request = next(0, 0);
	answer(1, &request, 0, 2); /* NOT_FOUND */
	zassert_equal(device_out.firmware.event, DRONECAN_FIRMWARE_FAILED);
	zassert_equal(device_out.firmware.error, 2);
}

ZTEST(dronecan_firmware, test_node_status_says_software_update_meanwhile)
{
	dronecan_endpoint_report(&device, 0);
	zassert_equal(device.node.condition.mode, 0); /* MODE_OPERATIONAL */
	zassert_equal(begin(1, TOOL, "f"), 0);
	dronecan_endpoint_report(&device, 2);
	zassert_equal(device.node.condition.mode, 3); /* MODE_SOFTWARE_UPDATE */
	dronecan_firmware_stop(&device.firmware);
	dronecan_endpoint_report(&device, 3);
	zassert_equal(device.node.condition.mode, 0);
}
