/* SPDX-License-Identifier: Apache-2.0 */
/* The controller on a bus that the test plays: mailboxes, arbitration, fault confinement. */
#include <zephyr/drivers/can.h>
#include <zephyr/ztest.h>

#include "fake_bus.h"

#define MAILBOXES 3 /* native.dts */

static const struct device *const can = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));

CAN_MSGQ_DEFINE(bus_frames, 16);

static enum can_state states[8];
static struct can_bus_err_cnt errors[8];
static uint32_t state_count;
static int results[16];
static uint32_t result_count;

static void on_state(const struct device *dev, enum can_state state, struct can_bus_err_cnt err_cnt,
                     void *user_data)
{
	zassert_true(k_is_in_isr());
	if (state_count < ARRAY_SIZE(states)) {
		states[state_count] = state;
		errors[state_count] = err_cnt;
	}
	state_count++;
}

static void on_sent(const struct device *dev, int error, void *user_data)
{
	results[result_count++] = error;
}

static void start(can_mode_t mode)
{
	(void)can_stop(can);
	zassert_ok(can_set_mode(can, mode));
	zassert_ok(can_set_bitrate(can, 1000000));
	zassert_ok(can_start(can));
	state_count = 0;
	result_count = 0;
}

static void before(void *fixture)
{
	const struct can_filter all = {.flags = 0};

	fake_bus_attach();
	k_msgq_purge(&bus_frames);
	zassert_true(can_add_rx_filter_msgq(can, &bus_frames, &all) >= 0);
	can_set_state_change_callback(can, on_state, NULL);
	start(CAN_MODE_NORMAL);
}

static void after(void *fixture)
{
	(void)can_stop(can);
	can_set_state_change_callback(can, NULL, NULL);
	for (int i = 0; i < can_get_max_filters(can, false); i++) {
		can_remove_rx_filter(can, i);
	}
	fake_bus_detach();
}

ZTEST_SUITE(can_bus, NULL, NULL, before, after, NULL);

static int post(uint32_t id)
{
	const struct can_frame frame = {.id = id, .dlc = 1, .data = {(uint8_t)result_count}};

	return can_send(can, &frame, K_NO_WAIT, on_sent, NULL);
}

static enum can_state state(void)
{
	enum can_state now;

	zassert_ok(can_get_state(can, &now, NULL));
	return now;
}

static struct can_bus_err_cnt counters(void)
{
	struct can_bus_err_cnt now;

	zassert_ok(can_get_state(can, NULL, &now));
	return now;
}

ZTEST(can_bus, test_waiting_frames_go_by_priority)
{
	fake_bus.result = CAN_HOST_BUSY;
	zassert_ok(post(0x300));
	zassert_ok(post(0x100));
	zassert_ok(post(0x200));
	zassert_equal(post(0x050), -EAGAIN);
	zassert_equal(result_count, 0);
	fake_bus.result = CAN_HOST_SENT;
	fake_bus_ready();
	zassert_equal(fake_bus.sent_count, MAILBOXES);
	zassert_equal(fake_bus.sent[0].id, 0x100);
	zassert_equal(fake_bus.sent[1].id, 0x200);
	zassert_equal(fake_bus.sent[2].id, 0x300);
	zassert_equal(result_count, MAILBOXES);
	zassert_equal(counters().tx_err_cnt, 0);
}

ZTEST(can_bus, test_frames_of_one_id_keep_their_order)
{
	fake_bus.result = CAN_HOST_BUSY;
	for (uint8_t i = 0; i < MAILBOXES; i++) {
		const struct can_frame frame = {.id = 7, .dlc = 1, .data = {i}};

		zassert_ok(can_send(can, &frame, K_NO_WAIT, on_sent, NULL));
	}
	fake_bus.result = CAN_HOST_SENT;
	fake_bus_ready();
	for (uint8_t i = 0; i < MAILBOXES; i++) {
		zassert_equal(fake_bus.sent[i].data[0], i);
	}
}

ZTEST(can_bus, test_waiting_for_a_mailbox_ends)
{
	const struct can_frame frame = {.id = 1};
	const int64_t begin = k_uptime_get();

	fake_bus.result = CAN_HOST_BUSY;
	for (int i = 0; i < MAILBOXES; i++) {
		zassert_ok(post(1));
	}
	zassert_equal(can_send(can, &frame, K_MSEC(20), on_sent, NULL), -EAGAIN);
	zassert_within(k_uptime_get() - begin, 20, 1);
}

ZTEST(can_bus, test_nobody_acknowledges)
{
	const uint32_t before_count = can_stats_get_ack_errors(can);

	fake_bus.result = CAN_HOST_NOBODY;
	zassert_ok(post(1));
	zassert_equal(state_count, 1);
	zassert_equal(states[0], CAN_STATE_ERROR_PASSIVE);
	zassert_equal(errors[0].tx_err_cnt, 128);
	zassert_equal(can_stats_get_ack_errors(can) - before_count, 1);
	zassert_ok(post(2));
	zassert_equal(fake_bus.attempts, 1);
	/* Somebody is there: both go; 128 - 2 = 126 is still a warning. */
	fake_bus.result = CAN_HOST_SENT;
	fake_bus_ready();
	zassert_equal(fake_bus.sent_count, 2);
	zassert_equal(counters().tx_err_cnt, 126);
	zassert_equal(state(), CAN_STATE_ERROR_WARNING);
	for (int i = 0; i < 31; i++) {
		result_count = 0;
		zassert_ok(post(3));
	}
	zassert_equal(counters().tx_err_cnt, 95);
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
}

ZTEST(can_bus, test_destroyed_frames_lead_to_bus_off)
{
	const uint64_t begin = (uint64_t)k_uptime_ticks();

	fake_bus.result = CAN_HOST_DESTROYED;
	zassert_ok(post(1));
	/* 8 each time: 96 after 12, 128 after 16, 256 after 32 */
	zassert_equal(fake_bus.attempts, 32);
	zassert_equal(state_count, 3);
	zassert_equal(states[0], CAN_STATE_ERROR_WARNING);
	zassert_equal(states[1], CAN_STATE_ERROR_PASSIVE);
	zassert_equal(states[2], CAN_STATE_BUS_OFF);
	zassert_equal(errors[2].tx_err_cnt, 255);
	zassert_equal(result_count, 1);
	zassert_equal(results[0], -ENETUNREACH);
	zassert_equal(post(2), -ENETUNREACH);
	zassert_equal(can_recover(can, K_NO_WAIT), -ENOTSUP);
	/* 128 times 11 bits of 1 us */
	k_sleep(K_TIMEOUT_ABS_TICKS(begin + 1407));
	zassert_equal(state(), CAN_STATE_BUS_OFF);
	k_sleep(K_TIMEOUT_ABS_TICKS(begin + 1409));
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
	zassert_equal(counters().tx_err_cnt, 0);
	fake_bus.result = CAN_HOST_SENT;
	zassert_ok(post(3));
	zassert_equal(fake_bus.sent_count, 1);
}

ZTEST(can_bus, test_one_shot_gives_up)
{
	start(CAN_MODE_ONE_SHOT);
	fake_bus.result = CAN_HOST_DESTROYED;
	zassert_ok(post(1));
	fake_bus.result = CAN_HOST_NOBODY;
	zassert_ok(post(2));
	zassert_equal(fake_bus.attempts, 2);
	zassert_equal(result_count, 2);
	zassert_equal(results[0], -EIO);
	zassert_equal(results[1], -EIO);
	fake_bus.result = CAN_HOST_SENT;
	zassert_ok(post(3));
	zassert_equal(results[2], 0);
}

ZTEST(can_bus, test_manual_recovery)
{
	start(CAN_MODE_MANUAL_RECOVERY);
	zassert_ok(can_recover(can, K_NO_WAIT));
	fake_bus_force_off(0);
	k_sleep(K_SECONDS(1));
	zassert_equal(state(), CAN_STATE_BUS_OFF);
	zassert_equal(can_recover(can, K_NO_WAIT), -EAGAIN);
	zassert_ok(can_recover(can, K_MSEC(2)));
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
}

ZTEST(can_bus, test_a_bus_that_stays_disturbed)
{
	const uint64_t begin = (uint64_t)k_uptime_ticks();

	fake_bus_force_off(50000);
	k_sleep(K_TIMEOUT_ABS_TICKS(begin + 50000 + 1407));
	zassert_equal(state(), CAN_STATE_BUS_OFF);
	k_sleep(K_TIMEOUT_ABS_TICKS(begin + 50000 + 1409));
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
}

ZTEST(can_bus, test_bus_off_hears_nothing)
{
	struct can_frame frame;

	fake_bus_force_off(0);
	fake_bus_receive(5, 0, 0);
	zassert_not_equal(k_msgq_get(&bus_frames, &frame, K_NO_WAIT), 0);
	k_sleep(K_MSEC(2));
	fake_bus_receive(6, 0, 0);
	zassert_ok(k_msgq_get(&bus_frames, &frame, K_NO_WAIT));
	zassert_equal(frame.id, 6);
}

ZTEST(can_bus, test_receive_errors_never_lead_to_bus_off)
{
	const uint32_t before_count = can_stats_get_crc_errors(can);

	for (int i = 0; i < 95; i++) {
		fake_bus_tell(CAN_HOST_CRC_ERROR);
	}
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
	fake_bus_tell(CAN_HOST_CRC_ERROR);
	zassert_equal(state(), CAN_STATE_ERROR_WARNING);
	for (int i = 0; i < 32; i++) {
		fake_bus_tell(CAN_HOST_CRC_ERROR);
	}
	zassert_equal(state(), CAN_STATE_ERROR_PASSIVE);
	for (int i = 0; i < 300; i++) {
		fake_bus_tell(CAN_HOST_CRC_ERROR);
	}
	zassert_equal(state(), CAN_STATE_ERROR_PASSIVE);
	zassert_equal(counters().rx_err_cnt, 255);
	zassert_equal(can_stats_get_crc_errors(can) - before_count, 95 + 1 + 32 + 300);
	/* ISO 11898-1: to 119…127 */
	fake_bus_receive(1, 0, 0);
	zassert_equal(counters().rx_err_cnt, 119);
	zassert_equal(state(), CAN_STATE_ERROR_WARNING);
	for (int i = 0; i < 24; i++) {
		fake_bus_receive(1, 0, 0);
	}
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
}

ZTEST(can_bus, test_each_kind_of_error_has_its_counter)
{
	const uint32_t bit0 = can_stats_get_bit0_errors(can);
	const uint32_t bits = can_stats_get_bit_errors(can);
	const uint32_t stuff = can_stats_get_stuff_errors(can);
	const uint32_t form = can_stats_get_form_errors(can);
	const uint32_t overruns = can_stats_get_rx_overruns(can);

	fake_bus_tell(CAN_HOST_BIT0_ERROR);
	fake_bus_tell(CAN_HOST_BIT1_ERROR);
	fake_bus_tell(CAN_HOST_STUFF_ERROR);
	fake_bus_tell(CAN_HOST_FORM_ERROR);
	fake_bus_tell(CAN_HOST_OVERRUN);
	zassert_equal(can_stats_get_bit0_errors(can) - bit0, 1);
	zassert_equal(can_stats_get_bit_errors(can) - bits, 2);
	zassert_equal(can_stats_get_stuff_errors(can) - stuff, 1);
	zassert_equal(can_stats_get_form_errors(can) - form, 1);
	zassert_equal(can_stats_get_rx_overruns(can) - overruns, 1);
}

ZTEST(can_bus, test_stopping_ends_what_waits)
{
	fake_bus.result = CAN_HOST_BUSY;
	zassert_ok(post(1));
	zassert_ok(post(2));
	zassert_ok(can_stop(can));
	zassert_equal(result_count, 2);
	zassert_equal(results[0], -ENETDOWN);
	zassert_equal(results[1], -ENETDOWN);
	fake_bus_receive(5, 0, 0);
	start(CAN_MODE_NORMAL);
	zassert_equal(k_msgq_num_used_get(&bus_frames), 0);
	fake_bus.result = CAN_HOST_SENT;
	for (int i = 0; i < MAILBOXES + 1; i++) {
		zassert_ok(post(3));
	}
	zassert_equal(fake_bus.sent_count, MAILBOXES + 1);
}

ZTEST(can_bus, test_stopping_ends_recovery)
{
	fake_bus_force_off(0);
	start(CAN_MODE_NORMAL);
	zassert_equal(state(), CAN_STATE_ERROR_ACTIVE);
	for (int i = 0; i < 96; i++) {
		fake_bus_tell(CAN_HOST_STUFF_ERROR);
	}
	/* Recovery would have cleared the counters by now. */
	k_sleep(K_MSEC(2));
	zassert_equal(state(), CAN_STATE_ERROR_WARNING);
	zassert_equal(counters().rx_err_cnt, 96);
}

ZTEST(can_bus, test_a_remote_frame_has_a_length_and_no_data)
{
	const struct can_frame frame = {.id = 1, .dlc = 2, .flags = CAN_FRAME_RTR, .data = {1, 2}};

	zassert_ok(can_send(can, &frame, K_NO_WAIT, on_sent, NULL));
	zassert_equal(fake_bus.sent[0].flags, CAN_HOST_REMOTE);
	zassert_equal(fake_bus.sent[0].length, 2);
	zassert_mem_equal(fake_bus.sent[0].data, "\0\0", 2);
}

ZTEST(can_bus, test_a_classic_node_does_not_hear_fd)
{
	struct can_frame frame;
	const uint32_t form = can_stats_get_form_errors(can);

	fake_bus_receive(1, CAN_HOST_FD, 12);
	zassert_not_equal(k_msgq_get(&bus_frames, &frame, K_NO_WAIT), 0);
	zassert_equal(can_stats_get_form_errors(can) - form, 1);
	start(CAN_MODE_FD);
	fake_bus_receive(1, CAN_HOST_FD, 12);
	zassert_ok(k_msgq_get(&bus_frames, &frame, K_NO_WAIT));
	zassert_equal(frame.flags, CAN_FRAME_FDF);
	zassert_equal(frame.dlc, 9);
	zassert_equal(frame.data[11], 11);
}

static void answer(const struct device *dev, struct can_frame *frame, void *user_data)
{
	frame->id++;
	zassert_ok(can_send(dev, frame, K_NO_WAIT, on_sent, NULL));
}

ZTEST(can_bus, test_callbacks_may_send)
{
	const struct can_filter filter = {.id = 0x10, .mask = CAN_STD_ID_MASK};

	zassert_true(can_add_rx_filter(can, answer, NULL, &filter) >= 0);
	fake_bus_receive(0x10, 0, 3);
	zassert_equal(fake_bus.sent_count, 1);
	zassert_equal(fake_bus.sent[0].id, 0x11);
	zassert_equal(fake_bus.sent[0].length, 3);
}
