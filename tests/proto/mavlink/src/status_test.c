/* SPDX-License-Identifier: Apache-2.0 */
/* ILLUMINATOR_STATUS, HEARTBEAT's state, and STATUSTEXT. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_status, NULL, NULL, fixture_before, NULL, NULL);

ZTEST(mavlink_status, test_status_equals_pymavlink)
{
	thermal_report(THERMAL_STATE_NORMAL, THERMAL_FAULT_NONE, 41250);
	receive(0, COMMAND_CONFIGURE, sizeof(COMMAND_CONFIGURE));
	now_us = 1500000;
	endpoint.components[0].sequence[0] = 0;
	zassert_equal(COMMAND(512, 440), MAV_RESULT_ACCEPTED);
	assert_sent(1, 0, STATUS_CONFIGURED, sizeof(STATUS_CONFIGURED));
}

ZTEST(mavlink_status, test_status_at_start)
{
	const mavlink_illuminator_status_t status = status_now();

	zassert_equal(status.enable, 0);
	zassert_equal(status.mode, 1);
	zassert_equal(status.mode_bitmask, 3);
	zassert_equal(status.error_status, 0);
	zassert_equal(status.strobe_period, 0.0f);
	zassert_equal(status.min_strobe_period, 0.01f);
	zassert_equal(status.max_strobe_period, 10.0f);
	zassert_true(isnan(status.temp_c)); /* no sample yet */
}

ZTEST(mavlink_status, test_error_flags)
{
	thermal_report(THERMAL_STATE_THROTTLING, THERMAL_FAULT_NONE, 75000);
	zassert_equal(status_now().error_status, 1);
	zassert_equal(status_now().temp_c, 75.0f);
	thermal_report(THERMAL_STATE_SHUTDOWN, THERMAL_FAULT_NONE, 90000);
	zassert_equal(status_now().error_status, 2);
	thermal_report(THERMAL_STATE_NORMAL, THERMAL_FAULT_OPEN, 0);
	zassert_equal(status_now().error_status, 4);
	zassert_true(isnan(status_now().temp_c));
}

ZTEST(mavlink_status, test_status_reports_what_was_commanded_not_throttled)
{
	zassert_equal(COMMAND(406, 1, 100, 0, 0), MAV_RESULT_ACCEPTED);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	thermal_report(THERMAL_STATE_THROTTLING, THERMAL_FAULT_NONE, 80000); /* limit 50 % */
	zassert_equal(status_now().brightness, 100.0f);
	zassert_equal(status_now().enable, 1);
}

ZTEST(mavlink_status, test_first_status_after_the_acknowledgement_shows_the_new_state)
{
	run_until(SECOND / 2);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 1);
	zassert_equal(run_until(SECOND).last_status.enable, 1);
}

ZTEST(mavlink_status, test_heartbeat_equals_pymavlink)
{
	mavlink_endpoint_step(&endpoint, 0, &out);
	assert_sent(0, 0, HEARTBEAT, sizeof(HEARTBEAT));
}

ZTEST(mavlink_status, test_heartbeat_state)
{
	zassert_equal(run_until(0).last_heartbeat.system_status, MAV_STATE_ACTIVE);
	thermal_report(THERMAL_STATE_SHUTDOWN, THERMAL_FAULT_NONE, 90000);
	zassert_equal(run_until(SECOND).last_heartbeat.system_status, MAV_STATE_CRITICAL);
	thermal_report(THERMAL_STATE_NORMAL, THERMAL_FAULT_NONE, 50000);
	zassert_equal(run_until(2 * SECOND).last_heartbeat.system_status, MAV_STATE_ACTIVE);
}

/* --- STATUSTEXT ------------------------------------------------------------------------------- */

ZTEST(mavlink_status, test_notice_becomes_a_text_on_every_link)
{
	run_until(0);
	endpoint.components[0].sequence[0] = 0;
	thermal_report(THERMAL_STATE_THROTTLING, THERMAL_FAULT_NONE, 75000);
	/* The status goes first: it reports the same change. */
	const struct tally tally = run_until(SECOND / 2);

	zassert_equal(tally.texts[0], 1);
	zassert_equal(tally.texts[1], 1);
	zassert_equal(tally.last_text.severity, 4); /* MAV_SEVERITY_WARNING */
	zassert_mem_equal(tally.last_text.text, "Thermal throttling begins", 26);
}

ZTEST(mavlink_status, test_text_equals_pymavlink)
{
	run_until(0);
	endpoint.components[0].sequence[0] = 0;
	zassert_true(mavlink_endpoint_text(&endpoint, now_us, 4, "Thermal throttling begins"));
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_equal(out.count, 2);
	assert_sent(0, 0, TEXT_THROTTLING, sizeof(TEXT_THROTTLING));
	zassert_equal(out.frames[1].link, 1);
}

ZTEST(mavlink_status, test_sensor_failure_says_what_is_wrong)
{
	run_until(0);
	thermal_report(THERMAL_STATE_NORMAL, THERMAL_FAULT_OPEN, 0);

	const struct tally tally = run_until(SECOND / 2);

	zassert_equal(tally.texts[0], 1);
	zassert_equal(tally.last_text.severity, 3); /* MAV_SEVERITY_ERROR */
	zassert_mem_equal(tally.last_text.text, "Temperature sensor failed: open", 32);
}

ZTEST(mavlink_status, test_the_same_notice_is_told_once_in_ten_seconds)
{
	run_until(0);
	struct tally tally;
	uint32_t texts = 0;

	for (int i = 1; i <= 18; i++) {
		thermal_report(i % 2 == 0 ? THERMAL_STATE_NORMAL : THERMAL_STATE_THROTTLING,
		               THERMAL_FAULT_NONE, 75000);
		tally = run_until(i * SECOND / 2);
		texts += tally.texts[0];
	}
	zassert_equal(texts, 2); /* it began, it ended: within 9 s no more */
	zassert_true(endpoint.texts.dropped >= 16);
}

ZTEST(mavlink_status, test_texts_come_in_a_burst_then_one_in_two_seconds)
{
	run_until(0);
	for (int i = 0; i < 4; i++) {
		zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, "text"));
	}
	run_until(now_us);
	zassert_false(mavlink_endpoint_text(&endpoint, now_us, 6, "one too many"));
	zassert_equal(endpoint.texts.dropped, 1);
	run_until(2 * SECOND - 1);
	zassert_false(mavlink_endpoint_text(&endpoint, now_us, 6, "still too many"));
	run_until(2 * SECOND);
	zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, "one more"));
	zassert_false(mavlink_endpoint_text(&endpoint, now_us, 6, "not two"));
	run_until(5 * SECOND); /* one and a half periods on: the half is not lost */
	zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, "one more"));
	run_until(6 * SECOND);
	zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, "one more"));
}

ZTEST(mavlink_status, test_long_text_is_cut_at_fifty_bytes)
{
	static const char text[] = "0123456789012345678901234567890123456789"
				   "0123456789 and what does not fit";

	zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, text));
	zassert_mem_equal(run_until(0).last_text.text, text, 50);
}
