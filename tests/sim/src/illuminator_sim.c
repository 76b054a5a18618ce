/* SPDX-License-Identifier: Apache-2.0 */
/* Random events, half of them wrong, and what must hold after each. */
#include "core/illuminator.h"

#include <zephyr/ztest.h>

#include "replay.h"

#define EVENTS 3000

ZTEST_SUITE(core_illuminator_sim, NULL, NULL, NULL, NULL, NULL);

static uint32_t around(struct dice *dice, uint32_t limit)
{
	switch (dice_next(dice) % 6) {
	case 0:
		return 0;
	case 1:
		return limit;
	case 2:
		return limit + 1;
	case 3:
		return dice_next(dice);
	default:
		return (uint32_t)dice_between(dice, 0, limit);
	}
}

static struct illuminator_event any_event(struct dice *dice)
{
	struct illuminator_event event = {.kind = (enum illuminator_event_kind)(
						  dice_next(dice) % (ILLUMINATOR_EVENT_POWER + 1))};

	switch (event.kind) {
	case ILLUMINATOR_EVENT_ON_OFF:
		event.on_off = dice_once_in(dice, 2);
		break;
	case ILLUMINATOR_EVENT_CONFIGURE:
		event.configure = (struct illuminator_configure){
			.mode = around(dice, 2),
			.brightness_ppm = around(dice, PPM_ONE),
			.strobe_period_us = around(dice, 10000000),
			.duty_ppm = around(dice, PPM_ONE),
		};
		break;
	case ILLUMINATOR_EVENT_BRIGHTNESS:
		event.brightness_ppm = around(dice, PPM_ONE);
		break;
	case ILLUMINATOR_EVENT_THERMAL:
		event.thermal = (struct thermal_report){
			.state = dice_next(dice) % (THERMAL_STATE_SHUTDOWN + 1),
			.sensor = dice_next(dice) % (THERMAL_SENSOR_FAILED + 1),
			.fault = dice_next(dice) % (THERMAL_FAULT_MISSING + 1),
			.flags = dice_next(dice) % 8,
		};
		break;
	case ILLUMINATOR_EVENT_CONFIG:
		event.config.min_period_us = (uint32_t)dice_between(dice, 100, 100000);
		event.config.max_period_us =
			(uint32_t)dice_between(dice, event.config.min_period_us, 20000000);
		event.config.curve = dice_next(dice) % 2;
		event.config.beacon = (struct illuminator_beacon){
			.period_us = dice_next(dice),
			.duty_ppm = (uint32_t)dice_between(dice, 0, PPM_ONE),
			.brightness_ppm = (uint32_t)dice_between(dice, 0, PPM_ONE),
		};
		if (dice_once_in(dice, 2)) {
			event.config.program = (struct program){
				.kind = PROGRAM_SOS,
				.unit_us = (uint32_t)dice_between(dice, 1, 1000000),
			};
		}
		break;
	case ILLUMINATOR_EVENT_RESTORE:
		event.restore = (struct illuminator_settings){
			.enable = dice_once_in(dice, 2),
			.mode = around(dice, 2),
			.brightness_ppm = around(dice, PPM_ONE),
			.strobe_period_us = around(dice, 10000000),
			.duty_ppm = around(dice, PPM_ONE),
		};
		break;
	case ILLUMINATOR_EVENT_FALLBACK:
		event.fallback = dice_next(dice) % (ILLUMINATOR_FALLBACK_BEACON + 1);
		break;
	case ILLUMINATOR_EVENT_POWER:
		event.powered = dice_once_in(dice, 2);
		break;
	case ILLUMINATOR_EVENT_TEST:
		event.test.on = dice_once_in(dice, 2);
		event.test.brightness_ppm = around(dice, PPM_ONE);
		break;
	}
	return event;
}

static void assert_plan(const struct illuminator *light)
{
	const struct light_plan *plan = &light->plan;

	zassert_equal(plan->on, light->settings.enable || light->test.on, "seed %u", replay_seed());
	zassert_true(plan->level_ppm <= PPM_ONE, "seed %u", replay_seed());
	if (plan->period_us > 0) {
		zassert_true(plan->on_us > 0 && plan->on_us < plan->period_us, "seed %u",
		             replay_seed());
		zassert_equal(plan->period_us, light->settings.strobe_period_us, "seed %u",
		              replay_seed());
	} else {
		zassert_equal(plan->on_us, 0, "seed %u", replay_seed());
	}
	if (plan->program.kind != PROGRAM_NONE) {
		zassert_true(plan->on && !plan->external_sync &&
		                     light->settings.strobe_period_us == 0,
		             "seed %u", replay_seed());
	}
}

static bool settings_differ(const struct illuminator_settings *a,
                            const struct illuminator_settings *b)
{
	return a->enable != b->enable || a->mode != b->mode ||
	       a->brightness_ppm != b->brightness_ppm ||
	       a->strobe_period_us != b->strobe_period_us || a->duty_ppm != b->duty_ppm;
}

static bool plans_differ(const struct light_plan *a, const struct light_plan *b)
{
	return a->on != b->on || a->external_sync != b->external_sync ||
	       a->level_ppm != b->level_ppm || a->period_us != b->period_us ||
	       a->on_us != b->on_us || !program_equal(&a->program, &b->program);
}

static void assert_step(const struct illuminator *before, const struct illuminator *after,
                        enum illuminator_event_kind kind, enum illuminator_result result,
                        const struct illuminator_outbox *out)
{
	const bool changed = settings_differ(&before->settings, &after->settings);
	const bool replanned = plans_differ(&before->plan, &after->plan);

	zassert_equal(after->revision - before->revision, changed ? 1 : 0, "seed %u",
	              replay_seed());
	zassert_equal(out->light, replanned, "seed %u", replay_seed());
	zassert_equal(out->settings, changed, "seed %u", replay_seed());
	if (result != ILLUMINATOR_ACCEPTED) {
		zassert_false(changed || replanned || out->status || out->notices != 0, "seed %u",
		              replay_seed());
	}
	if (!before->settings.enable && after->settings.enable) {
		zassert_true(before->thermal.state != THERMAL_STATE_SHUTDOWN ||
		                     kind == ILLUMINATOR_EVENT_FALLBACK,
		             "seed %u: only the beacon may be armed in shutdown", replay_seed());
	}
	zassert_false(after->unpowered && after->plan.on, "seed %u", replay_seed());
}

static void any_events(struct dice *dice)
{
	const struct illuminator_config config = {
		.min_period_us = 10000,
		.max_period_us = 10000000,
		.curve = ILLUMINATOR_CURVE_PERCEPTUAL,
	};
	struct illuminator light;

	illuminator_init(&light, &config);
	for (int i = 0; i < EVENTS; i++) {
		const struct illuminator_event event = any_event(dice);
		struct illuminator_outbox out;

		struct illuminator before = light;
		const enum illuminator_result result = illuminator_step(&light, i, &event, &out);

		assert_step(&before, &light, event.kind, result, &out);
		assert_plan(&light);
		/* The same again changes nothing and gives the same result. */
		before = light;
		if (event.kind != ILLUMINATOR_EVENT_THERMAL) {
			zassert_equal(illuminator_step(&light, i, &event, &out), result, "seed %u",
			              replay_seed());
		}
		zassert_equal(light.revision, before.revision, "seed %u", replay_seed());
	}
}

ZTEST(core_illuminator_sim, test_any_events_keep_the_promises)
{
	replay_seeds("core_illuminator_sim", any_events);
}
