/* SPDX-License-Identifier: Apache-2.0 */
/* Streams: rates, silence, reports of changes, deadlines, and a full outbox. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_stream, NULL, NULL, fixture_before, NULL, NULL);

ZTEST(mavlink_stream, test_heartbeat_and_status_at_1_hz_on_every_link_without_asking)
{
	const struct tally tally = run_until(60 * SECOND);

	for (uint8_t link = 0; link < 2; link++) {
		zassert_equal(tally.heartbeats[link], 61); /* 0 s, 1 s, … 60 s */
		zassert_equal(tally.statuses[link], 61);
		zassert_equal(tally.others[link], 0);
	}
	for (uint8_t link = 2; link < MAVLINK_LINKS_MAX; link++) {
		zassert_equal(tally.heartbeats[link], 0);
	}
}

ZTEST(mavlink_stream, test_intervals_do_not_drift)
{
	run_until(0);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), SECOND);
	/* Each step comes 3 ms late; the grid stays. */
	for (int i = 1; i < 100; i++) {
		zassert_equal(mavlink_endpoint_deadline_us(&endpoint), i * SECOND);
		mavlink_endpoint_step(&endpoint, i * SECOND + 3000, &out);
		zassert_equal(out.count, 4);
	}
}

ZTEST(mavlink_stream, test_a_long_pause_is_not_made_up_for)
{
	run_until(0);
	now_us = 100 * SECOND + 1;
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_equal(out.count, 4);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), 101 * SECOND + 1);
}

ZTEST(mavlink_stream, test_minus_one_silences_the_stream_and_zero_restores_it)
{
	run_until(0);
	zassert_equal(COMMAND(511, 440, -1), MAV_RESULT_ACCEPTED);
	struct tally tally = run_until(10 * SECOND);

	zassert_equal(tally.statuses[0], 0);
	zassert_equal(tally.statuses[1], 10);
	zassert_equal(tally.heartbeats[0], 10);
	zassert_equal(COMMAND(511, 440, 0), MAV_RESULT_ACCEPTED);
	tally = run_until(20 * SECOND);
	zassert_equal(tally.statuses[0], 10);
}

ZTEST(mavlink_stream, test_a_silenced_stream_tells_no_change_either)
{
	run_until(0);
	zassert_equal(COMMAND(511, 440, -1), MAV_RESULT_ACCEPTED);
	run_until(SECOND / 4);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 1);

	const struct tally tally = run_until(SECOND / 2);

	zassert_equal(tally.statuses[0], 0);
	zassert_equal(tally.statuses[1], 1); /* there it is not silenced */
}

ZTEST(mavlink_stream, test_a_change_is_told_at_once)
{
	run_until(SECOND / 2);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), SECOND / 2);

	const struct tally tally = run_until(SECOND / 2);

	zassert_equal(tally.statuses[0], 1);
	zassert_equal(tally.statuses[1], 1);
	zassert_equal(tally.last_status.enable, 1);
}

ZTEST(mavlink_stream, test_changes_are_told_at_most_ten_times_a_second)
{
	struct tally tally;
	uint32_t statuses = 0;

	run_until(0);
	for (int i = 1; i <= 1000; i++) {
		zassert_equal(COMMAND(405, (float)(i & 1)), MAV_RESULT_ACCEPTED);
		tally = run_until(i * SECOND / 1000);
		statuses += tally.statuses[0];
	}
	zassert_between_inclusive(statuses, 9, 10);
	/* The last change is told as well. */
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	tally = run_until(now_us + MAVLINK_CHANGE_GAP_MIN_US);
	zassert_equal(tally.last_status.enable, 1);
}

ZTEST(mavlink_stream, test_what_changes_nothing_tells_nothing)
{
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	run_until(SECOND / 2);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(COMMAND(405, 2), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(400, 2), MAV_RESULT_UNSUPPORTED);
	zassert_equal(run_until(SECOND - 1).statuses[0], 0);
}

ZTEST(mavlink_stream, test_a_faster_interval_takes_effect)
{
	run_until(0);
	zassert_equal(COMMAND(511, 440, 100000), MAV_RESULT_ACCEPTED);
	zassert_equal(run_until(10 * SECOND).statuses[0], 100);
}

ZTEST(mavlink_stream, test_asking_for_the_interval_in_force_again_delays_nothing)
{
	uint32_t statuses = 0;

	run_until(0);
	/* A client that repeats its request faster than the interval must not starve itself. */
	for (int i = 1; i <= 100; i++) {
		zassert_equal(COMMAND(511, 440, 1000000), MAV_RESULT_ACCEPTED);
		statuses += run_until(i * SECOND / 10).statuses[0];
	}
	zassert_equal(statuses, 10);
}

ZTEST(mavlink_stream, test_a_message_on_request_can_be_streamed)
{
	run_until(0);
	zassert_equal(COMMAND(511, 396, 2000000), MAV_RESULT_ACCEPTED);
	zassert_equal(run_until(10 * SECOND).others[0], 5);
	zassert_equal(COMMAND(511, 396, 0), MAV_RESULT_ACCEPTED); /* default: only on request */
	zassert_equal(run_until(20 * SECOND).others[0], 0);
}

ZTEST(mavlink_stream, test_more_than_the_outbox_holds_goes_in_several_steps)
{
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 0x0F};
	uint32_t frames = 0;
	int steps = 0;

	mavlink_endpoint_init(&endpoint, &config);
	mavlink_endpoint_add(&endpoint, 0, 243, &mavlink_illuminator_profile, &service);
	for (uint8_t i = 0; i < 2; i++) {
		zassert_equal(COMMAND(511, i == 0 ? 396 : 148, 1000000, 0, 0, 0, 0, 2),
		              MAV_RESULT_ACCEPTED);
	}
	run_until(SECOND - 1);
	now_us = SECOND;
	for (int i = 0; i < 4; i++) {
		zassert_true(mavlink_endpoint_text(&endpoint, now_us, 6, "text"));
	}
	while (mavlink_endpoint_deadline_us(&endpoint) <= now_us) {
		mavlink_endpoint_step(&endpoint, now_us, &out);
		frames += out.count;
		steps++;
	}
	zassert_equal(frames, 4 * 4 + 4 * 4); /* four streams and four texts on four links */
	zassert_true(steps > 1);
}

ZTEST(mavlink_stream, test_a_step_before_the_deadline_sends_nothing)
{
	run_until(0);
	mavlink_endpoint_step(&endpoint, SECOND - 1, &out);
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_stream, test_an_endpoint_without_components_is_never_due)
{
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 0x0F};

	mavlink_endpoint_init(&endpoint, &config);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), TIME_NEVER_US);
}

ZTEST(mavlink_stream, test_a_new_system_id_is_used_and_listened_to)
{
	mavlink_endpoint_set_system_id(&endpoint, 42);
	receive_long(0, 1, 243, 405, (struct command_params){{1}});
	zassert_equal(out.count, 0);
	receive_long(0, 42, 243, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).system_id, 42);
}

ZTEST(mavlink_stream, test_a_link_that_goes_is_silent_and_starts_anew_when_it_comes)
{
	run_until(0);
	zassert_equal(COMMAND(511, 440, 100000), MAV_RESULT_ACCEPTED);
	mavlink_endpoint_link_down(&endpoint, 0);
	struct tally tally = run_until(10 * SECOND);

	zassert_equal(tally.heartbeats[0] + tally.statuses[0], 0);
	zassert_equal(tally.heartbeats[1], 10);
	now_us = 10 * SECOND + 500000;
	mavlink_endpoint_link_up(&endpoint, now_us, 0);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), now_us);
	tally = run_until(20 * SECOND);
	zassert_equal(tally.heartbeats[0], 10); /* 10.5 s … 19.5 s: at once, then each second */
	zassert_equal(tally.statuses[0], 10);   /* the default rate, not the one asked for before */
	zassert_equal(tally.heartbeats[1], 10);
	zassert_equal(endpoint.links[0].version, 0);
}
