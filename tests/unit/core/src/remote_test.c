/* SPDX-License-Identifier: Apache-2.0 */
#include "core/remote.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S INT64_C(1000000)

static struct remote remote;

static void before(void *fixture)
{
	remote_init(&remote);
}

ZTEST_SUITE(core_remote, NULL, NULL, before, NULL, NULL);

static struct remote_output update(int64_t now_us, struct remote_input input)
{
	return remote_update(&remote, now_us, &input);
}

static bool is_nothing(const struct remote_output *output)
{
	return !output->toggle_light && !output->toggle_strobe && !output->set_brightness &&
	       !output->move;
}

ZTEST(core_remote, test_a_press_toggles_once)
{
	struct remote_output output = update(0, (struct remote_input){.light = true});

	zassert_true(output.toggle_light && !output.toggle_strobe);
	output = update(100000, (struct remote_input){.light = true, .strobe = true});
	zassert_true(!output.toggle_light && output.toggle_strobe);
	output = update(200000, (struct remote_input){.strobe = true});
	zassert_true(is_nothing(&output), "a release does nothing");
	output = update(300000, (struct remote_input){.light = true, .strobe = true});
	zassert_true(output.toggle_light && !output.toggle_strobe);
}

ZTEST(core_remote, test_slider_counts_when_it_moves_and_not_at_0)
{
	struct remote_output output = update(0, (struct remote_input){.brightness_ppm = 400000});

	zassert_true(output.set_brightness);
	zassert_equal(output.brightness_ppm, 400000);
	output = update(1, (struct remote_input){.brightness_ppm = 400000});
	zassert_true(is_nothing(&output), "a resting slider takes the lamp from nobody");
	output = update(2, (struct remote_input){.brightness_ppm = 0});
	zassert_true(is_nothing(&output), "0 is an action that was not named");
	output = update(3, (struct remote_input){.brightness_ppm = 400000});
	zassert_true(output.set_brightness);
}

ZTEST(core_remote, test_axes_move_and_stop)
{
	struct remote_output output = update(0, (struct remote_input){.pan_ppm = -1000000});

	zassert_true(output.move);
	zassert_equal(output.pan_ppm, -1000000);
	zassert_equal(output.tilt_ppm, 0);
	output = update(1, (struct remote_input){.pan_ppm = -1000000});
	zassert_true(output.move, "a speed has to be renewed");
	output = update(2, (struct remote_input){.tilt_ppm = 5});
	zassert_true(output.move);
	zassert_equal(output.pan_ppm, 0);
	zassert_equal(output.tilt_ppm, 5);
	output = update(3, (struct remote_input){.light = false});
	zassert_true(output.move && output.pan_ppm == 0 && output.tilt_ppm == 0);
	output = update(4, (struct remote_input){.light = false});
	zassert_true(is_nothing(&output), "it stands still, and somebody else may turn it");
}

ZTEST(core_remote, test_silence_stops_the_axes_and_leaves_the_lamp)
{
	struct remote_output output = update(
		5, (struct remote_input){.light = true, .brightness_ppm = 9, .pan_ppm = 100});

	zassert_equal(remote_deadline_us(&remote), 5 + 40000);
	output = remote_advance(&remote, 5 + 40000 - 1);
	zassert_true(is_nothing(&output));
	for (int64_t due_us = 5 + 40000; due_us < 5 + S; due_us += 40000) {
		output = remote_advance(&remote, due_us);
		zassert_true(output.move && output.pan_ppm == 100, "at %lld", (long long)due_us);
		zassert_true(!output.toggle_light && !output.set_brightness);
	}
	zassert_equal(remote_deadline_us(&remote), 5 + S);
	output = remote_advance(&remote, 5 + S - 1);
	zassert_true(is_nothing(&output));
	output = remote_advance(&remote, 5 + S);
	zassert_true(output.move);
	zassert_true(output.pan_ppm == 0 && output.tilt_ppm == 0);
	zassert_true(!output.toggle_light && !output.set_brightness);
	zassert_equal(remote_deadline_us(&remote), TIME_NEVER_US);
	output = remote_advance(&remote, 9 * S);
	zassert_true(is_nothing(&output));
	output = update(10 * S, (struct remote_input){.light = true});
	zassert_true(output.toggle_light, "it was released in between");
}

ZTEST(core_remote, test_impossible_axis_is_a_bug)
{
	expect_assert();
	update(0, (struct remote_input){.pan_ppm = 1000001});
	zassert_unreachable("no assertion");
}
