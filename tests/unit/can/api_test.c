/* SPDX-License-Identifier: Apache-2.0 */
/* Zephyr's CAN API in loopback mode. */
#include <string.h>

#include <zephyr/drivers/can.h>
#include <zephyr/ztest.h>

static const struct device *const can = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));

CAN_MSGQ_DEFINE(frames, 4);

static void before(void *fixture)
{
	zassert_true(device_is_ready(can));
	zassert_equal(can, DEVICE_DT_GET(DT_ALIAS(can_link0)));
	(void)can_stop(can);
	k_msgq_purge(&frames);
	zassert_ok(can_set_mode(can, CAN_MODE_LOOPBACK | CAN_MODE_FD));
	zassert_ok(can_start(can));
}

static void after(void *fixture)
{
	for (int i = 0; i < can_get_max_filters(can, false); i++) {
		can_remove_rx_filter(can, i);
	}
	(void)can_stop(can);
}

ZTEST_SUITE(can_api, NULL, NULL, before, after, NULL);

static int listen_to(uint32_t id, uint32_t mask, uint8_t flags)
{
	const struct can_filter filter = {.id = id, .mask = mask, .flags = flags};

	return can_add_rx_filter_msgq(can, &frames, &filter);
}

static int send(uint32_t id, uint8_t flags, uint8_t dlc)
{
	struct can_frame frame = {.id = id, .flags = flags, .dlc = dlc};

	for (uint8_t i = 0; i < sizeof(frame.data); i++) {
		frame.data[i] = (uint8_t)(i + 1);
	}
	return can_send(can, &frame, K_MSEC(1), NULL, NULL);
}

ZTEST(can_api, test_length_codes)
{
	/* ISO 11898-1, table of data length codes */
	static const uint8_t bytes[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

	for (uint8_t dlc = 0; dlc < 16; dlc++) {
		zassert_equal(can_dlc_to_bytes(dlc), bytes[dlc]);
		zassert_equal(can_bytes_to_dlc(bytes[dlc]), dlc);
	}
	zassert_equal(can_bytes_to_dlc(9), 9);
	zassert_equal(can_bytes_to_dlc(33), 14);
	zassert_equal(can_bytes_to_dlc(49), 15);
	zassert_equal(can_dlc_to_bytes(255), 64);
}

ZTEST(can_api, test_a_frame_comes_back_whole)
{
	struct can_frame frame;

	zassert_true(listen_to(0x555, CAN_STD_ID_MASK, 0) >= 0);
	zassert_ok(send(0x555, 0, 8));
	zassert_ok(k_msgq_get(&frames, &frame, K_NO_WAIT));
	zassert_equal(frame.id, 0x555);
	zassert_equal(frame.dlc, 8);
	zassert_equal(frame.flags, 0);
	zassert_mem_equal(frame.data, "\1\2\3\4\5\6\7\10", 8);
}

ZTEST(can_api, test_an_fd_frame_comes_back_whole)
{
	struct can_frame frame;

	zassert_true(listen_to(0x12345678, CAN_EXT_ID_MASK, CAN_FILTER_IDE) >= 0);
	zassert_ok(send(0x12345678, CAN_FRAME_IDE | CAN_FRAME_FDF | CAN_FRAME_BRS, 15));
	zassert_ok(k_msgq_get(&frames, &frame, K_NO_WAIT));
	zassert_equal(frame.id, 0x12345678);
	zassert_equal(frame.dlc, 15);
	zassert_equal(frame.flags, CAN_FRAME_IDE | CAN_FRAME_FDF | CAN_FRAME_BRS);
	zassert_equal(frame.data[63], 64);
}

ZTEST(can_api, test_filters_match_by_mask_and_kind_of_id)
{
	struct can_frame frame;

	zassert_true(listen_to(0x120, 0x7F0, 0) >= 0);
	zassert_ok(send(0x12F, 0, 0));
	zassert_ok(k_msgq_get(&frames, &frame, K_NO_WAIT));
	zassert_ok(send(0x130, 0, 0));
	zassert_ok(send(0x125, CAN_FRAME_IDE, 0));
	zassert_not_equal(k_msgq_get(&frames, &frame, K_NO_WAIT), 0);
}

ZTEST(can_api, test_a_removed_filter_hears_nothing)
{
	struct can_frame frame;
	const int filter = listen_to(0, 0, 0);

	can_remove_rx_filter(can, filter);
	zassert_ok(send(1, 0, 0));
	zassert_not_equal(k_msgq_get(&frames, &frame, K_NO_WAIT), 0);
	zassert_equal(listen_to(0, 0, 0), filter);
}

ZTEST(can_api, test_filters_end)
{
	const int count = can_get_max_filters(can, true);

	for (int i = 0; i < count; i++) {
		zassert_equal(listen_to((uint32_t)i, CAN_STD_ID_MASK, 0), i);
	}
	zassert_equal(listen_to(0, 0, 0), -ENOSPC);
	can_remove_rx_filter(can, -1);
	can_remove_rx_filter(can, count);
}

ZTEST(can_api, test_wrong_filters)
{
	const struct can_filter filter = {0};

	zassert_equal(listen_to(0x800, 0, 0), -EINVAL);
	zassert_equal(listen_to(0, 0x800, 0), -EINVAL);
	zassert_equal(listen_to(0x20000000, 0, CAN_FILTER_IDE), -EINVAL);
	zassert_equal(listen_to(0, 0, 0x80), -ENOTSUP);
	zassert_equal(can_add_rx_filter(can, NULL, NULL, &filter), -EINVAL);
	zassert_equal(can_add_rx_filter_msgq(can, &frames, NULL), -EINVAL);
}

ZTEST(can_api, test_a_full_queue_is_counted)
{
	const uint32_t before_count = can_stats_get_rx_overruns(can);

	zassert_true(listen_to(0, 0, 0) >= 0);
	for (uint32_t i = 0; i < 7; i++) {
		zassert_ok(send(i, 0, 0));
	}
	zassert_equal(k_msgq_num_used_get(&frames), 4);
	zassert_equal(can_stats_get_rx_overruns(can) - before_count, 3);
}

ZTEST(can_api, test_wrong_frames)
{
	zassert_equal(send(0x800, 0, 0), -EINVAL);
	zassert_equal(send(0x20000000, CAN_FRAME_IDE, 0), -EINVAL);
	zassert_equal(send(1, 0, 9), -EINVAL);
	zassert_equal(send(1, CAN_FRAME_FDF, 16), -EINVAL);
	zassert_equal(can_send(can, NULL, K_NO_WAIT, NULL, NULL), -EINVAL);
	zassert_equal(send(1, CAN_FRAME_BRS, 0), -ENOTSUP);
	zassert_equal(send(1, CAN_FRAME_FDF | CAN_FRAME_RTR, 0), -ENOTSUP);
	zassert_equal(send(1, 0x80, 0), -ENOTSUP);
}

ZTEST(can_api, test_fd_needs_its_mode)
{
	zassert_ok(can_stop(can));
	zassert_ok(can_set_mode(can, CAN_MODE_LOOPBACK));
	zassert_ok(can_start(can));
	zassert_equal(send(1, CAN_FRAME_FDF, 8), -ENOTSUP);
	zassert_ok(send(1, 0, 8));
}

ZTEST(can_api, test_listening_only)
{
	zassert_ok(can_stop(can));
	zassert_ok(can_set_mode(can, CAN_MODE_LISTENONLY));
	zassert_ok(can_start(can));
	zassert_equal(send(1, 0, 0), -ENOTSUP);
}

ZTEST(can_api, test_modes)
{
	can_mode_t capabilities;

	zassert_ok(can_get_capabilities(can, &capabilities));
	zassert_equal(capabilities, CAN_MODE_LOOPBACK | CAN_MODE_LISTENONLY | CAN_MODE_FD |
	                                    CAN_MODE_ONE_SHOT | CAN_MODE_MANUAL_RECOVERY);
	zassert_equal(can_get_mode(can), CAN_MODE_LOOPBACK | CAN_MODE_FD);
	zassert_equal(can_set_mode(can, CAN_MODE_NORMAL), -EBUSY);
	zassert_equal(can_set_bitrate(can, 500000), -EBUSY);
	zassert_equal(can_set_bitrate_data(can, 2000000), -EBUSY);
	zassert_ok(can_stop(can));
	zassert_equal(can_set_mode(can, CAN_MODE_3_SAMPLES), -ENOTSUP);
	zassert_equal(can_get_mode(can), CAN_MODE_LOOPBACK | CAN_MODE_FD);
}

ZTEST(can_api, test_start_and_stop)
{
	enum can_state state;

	zassert_equal(can_start(can), -EALREADY);
	zassert_ok(can_get_state(can, &state, NULL));
	zassert_equal(state, CAN_STATE_ERROR_ACTIVE);
	zassert_ok(can_stop(can));
	zassert_equal(can_stop(can), -EALREADY);
	zassert_ok(can_get_state(can, &state, NULL));
	zassert_equal(state, CAN_STATE_STOPPED);
	zassert_equal(send(1, 0, 0), -ENETDOWN);
	zassert_equal(can_recover(can, K_NO_WAIT), -ENETDOWN);
}

static struct {
	int count;
	bool in_isr;
	int error;
} call;

static void note_sent(const struct device *dev, int error, void *user_data)
{
	call.count++;
	call.in_isr = k_is_in_isr();
	call.error = error;
	zassert_equal(user_data, &call);
}

static void note_received(const struct device *dev, struct can_frame *frame, void *user_data)
{
	call.count++;
	call.in_isr = k_is_in_isr();
	zassert_equal(user_data, &call);
}

ZTEST(can_api, test_callbacks_run_in_interrupt_context)
{
	const struct can_frame frame = {.id = 1};
	const struct can_filter filter = {.id = 1, .mask = CAN_STD_ID_MASK};

	memset(&call, 0, sizeof(call));
	zassert_ok(can_send(can, &frame, K_NO_WAIT, note_sent, &call));
	zassert_equal(call.count, 1);
	zassert_true(call.in_isr);
	memset(&call, 0, sizeof(call));
	zassert_true(can_add_rx_filter(can, note_received, &call, &filter) >= 0);
	zassert_ok(can_send(can, &frame, K_NO_WAIT, note_sent, &call));
	zassert_equal(call.count, 2);
	zassert_true(call.in_isr);
}

ZTEST(can_api, test_remote_frames_are_dropped)
{
	struct can_frame frame;

	zassert_true(listen_to(0, 0, 0) >= 0);
	zassert_ok(send(1, CAN_FRAME_RTR, 2));
	zassert_not_equal(k_msgq_get(&frames, &frame, K_NO_WAIT), 0);
}
