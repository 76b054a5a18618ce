/* SPDX-License-Identifier: Apache-2.0 */
/* The one door: who may do what now, all or nothing, and what follows from it. */
#include "core/device.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S INT64_C(1000000)

static struct pharos_device device;
static struct pharos_device before_it; /* as it was */
static struct device_effects effects;
static int64_t now_us;

static struct illuminator *const light = &device.lamps[0].illuminator;

static const struct device_who mavlink = {.way = SECURITY_WAY_MAVLINK};
static const struct device_who dronecan = {.way = SECURITY_WAY_DRONECAN};
static const struct device_who repeating = {.way = SECURITY_WAY_DRONECAN, .is_repeated = true};
static const struct device_who shell = {.way = SECURITY_WAY_SHELL};

static const struct illuminator_event on = {.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = true};
static const struct illuminator_event off = {.kind = ILLUMINATOR_EVENT_ON_OFF};
static const struct gimbal_event right = {.kind = GIMBAL_EVENT_AIM,
                                          .aim[GIMBAL_PAN] = {GIMBAL_ANGLE, false, 30000}};

static void start(const struct device_config *config)
{
	now_us = 0;
	memset(&device, 0, sizeof(device));
	params_init(&device.params);
	device.params.values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&device, now_us, config);
}

static void before(void *fixture)
{
	const struct device_config config = {
		.gimbal = true,
		.actuators = {.power = 0x0F,
	                      .power_on = 0x07,
	                      .pwms = 0x01,
	                      .leds = 0x01,
	                      .thruster = true},
	};

	start(&config);
}

ZTEST_SUITE(core_device, NULL, NULL, before, NULL, NULL);

static enum device_result give(const struct device_who *who, const struct illuminator_event *event)
{
	return pharos_device_apply(&device, now_us, who, 0, event, 1);
}

static bool took(void)
{
	memset(&effects, 0, sizeof(effects));
	return pharos_device_take(&device, &effects);
}

static int32_t param_get(enum param_id id)
{
	return device.params.values[id];
}

static void param_set(enum param_id id, int32_t value)
{
	zassert_equal(pharos_device_set_param(&device, now_us, &shell, id, value), PARAMS_OK);
}

static void report(enum thermal_state state, enum thermal_sensor sensor)
{
	const struct thermal_report heat = {
		.state = state,
		.sensor = sensor,
		.fault = sensor == THERMAL_SENSOR_FAILED ? THERMAL_FAULT_OPEN : THERMAL_FAULT_NONE,
		.limit_ppm = state == THERMAL_STATE_SHUTDOWN ? 0 : PPM_ONE,
		.flags = state == THERMAL_STATE_SHUTDOWN ? THERMAL_FLAG_SHUTDOWN : 0,
	};

	pharos_device_report_heat(&device, now_us, 0, &heat);
}

/* --- a refused verb has changed nothing --------------------------------------------------------
 */

/* Counters aside, of which each machine has some. */
static void forget_counters(struct pharos_device *its)
{
	memset(&its->lamps[0].illuminator.stats, 0, sizeof(its->lamps[0].illuminator.stats));
	memset(&its->gimbal.stats, 0, sizeof(its->gimbal.stats));
}

static void remember(void)
{
	memcpy(&before_it, &device, sizeof(device));
}

static bool is_unchanged(void)
{
	static struct pharos_device now;

	memcpy(&now, &device, sizeof(device));
	forget_counters(&now);
	forget_counters(&before_it);
	return memcmp(&now, &before_it, sizeof(now)) == 0;
}

#define EXPECT_REFUSED(expected, verb)                                                             \
	do {                                                                                       \
		remember();                                                                        \
		zassert_equal(verb, expected);                                                     \
		zassert_true(is_unchanged());                                                      \
	} while (0)

ZTEST(core_device, test_values_out_of_range_change_nothing)
{
	const struct illuminator_event bright = {.kind = ILLUMINATOR_EVENT_BRIGHTNESS,
	                                         .brightness_ppm = PPM_ONE + 1};
	const struct gimbal_event far = {.kind = GIMBAL_EVENT_AIM,
	                                 .aim[GIMBAL_PAN] = {GIMBAL_ANGLE, false, 360001}};
	const struct actuators_event pwm = {.kind = ACTUATORS_EVENT_PWM, .pwm = {1000, 1001}};
	const struct actuators_event channel = {.kind = ACTUATORS_EVENT_POWER, .timed = {.op = 99}};

	EXPECT_REFUSED(DEVICE_DENIED, give(&mavlink, &bright));
	EXPECT_REFUSED(DEVICE_DENIED, pharos_device_point(&device, now_us, &mavlink, &far));
	EXPECT_REFUSED(DEVICE_DENIED, pharos_device_output(&device, now_us, &mavlink, &pwm));
	EXPECT_REFUSED(DEVICE_DENIED, pharos_device_output(&device, now_us, &mavlink, &channel));
	EXPECT_REFUSED(PARAMS_OUT_OF_RANGE,
	               pharos_device_set_param(&device, now_us, &mavlink, PARAM_LGT_CURVE, 2));
	EXPECT_REFUSED(PARAMS_UNKNOWN,
	               pharos_device_set_param(&device, now_us, &mavlink, PARAM_COUNT, 0));
	EXPECT_REFUSED(PARAMS_READ_ONLY,
	               pharos_device_set_param(&device, now_us, &mavlink, PARAM_LGT_SRC_NOW, 1));
	zassert_false(took());
	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED, "the nearest neighbour");
}

ZTEST(core_device, test_an_excluded_source_changes_nothing)
{
	const struct actuators_event lamp_off = {.kind = ACTUATORS_EVENT_POWER,
	                                         .timed = {.op = POWER_OP_OFF}};
	const struct actuators_event down = {.kind = ACTUATORS_EVENT_SHUTDOWN,
	                                     .timed = {.op = SHUTDOWN_OP_DOWN}};
	enum self_test_state obstacle;

	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	param_set(PARAM_LGT_SRC_EXCL, ARBITER_SOURCE_BIT(ARBITER_SOURCE_MAVLINK));
	EXPECT_REFUSED(DEVICE_EXCLUDED, give(&mavlink, &on));
	EXPECT_REFUSED(DEVICE_EXCLUDED, pharos_device_point(&device, now_us, &mavlink, &right));
	EXPECT_REFUSED(DEVICE_EXCLUDED, pharos_device_output(&device, now_us, &mavlink, &lamp_off));
	EXPECT_REFUSED(DEVICE_EXCLUDED, pharos_device_output(&device, now_us, &mavlink, &down));
	EXPECT_REFUSED(DEVICE_EXCLUDED,
	               pharos_device_test(&device, now_us, &mavlink, 0, PPM_ONE, &obstacle));
	zassert_equal(give(&dronecan, &on), DEVICE_ACCEPTED, "nobody else is");
	zassert_equal(pharos_device_point(&device, now_us, &dronecan, &right), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_a_source_with_priority_outranks_the_others_for_a_while)
{
	param_set(PARAM_LGT_SRC_PRIO, ARBITER_SOURCE_SHELL);
	param_set(PARAM_LGT_SRC_HOLD, 2000);
	zassert_equal(give(&shell, &on), DEVICE_ACCEPTED);
	zassert_equal(pharos_device_point(&device, now_us, &shell, &right), DEVICE_ACCEPTED);
	now_us = 2 * S - 1;
	EXPECT_REFUSED(DEVICE_OUTRANKED, give(&mavlink, &off));
	EXPECT_REFUSED(DEVICE_OUTRANKED, pharos_device_point(&device, now_us, &mavlink, &right));
	now_us = 2 * S;
	zassert_equal(give(&mavlink, &off), DEVICE_ACCEPTED);
	zassert_equal(pharos_device_point(&device, now_us, &mavlink, &right), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_not_now_changes_nothing)
{
	const struct illuminator_settings lit = {
		.enable = true, .mode = ILLUMINATOR_MODE_INTERNAL, .brightness_ppm = PPM_ONE};
	const struct actuators_event thrust = {.kind = ACTUATORS_EVENT_THRUSTER, .share_ppm = 1};

	report(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK);
	EXPECT_REFUSED(DEVICE_FAILED, give(&mavlink, &on));
	EXPECT_REFUSED(DEVICE_FAILED, pharos_device_restore(&device, now_us, 0, &lit));
	EXPECT_REFUSED(DEVICE_FAILED, pharos_device_output(&device, now_us, &mavlink, &thrust));
	zassert_equal(device.lamps[0].arbiter.commander, ARBITER_SOURCE_NONE);
	zassert_equal(give(&mavlink, &off), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_a_strobe_that_is_no_longer_allowed_is_restored_as_the_nearest)
{
	const struct illuminator_settings lit = {true, ILLUMINATOR_MODE_INTERNAL, 1, 60000000, 1};

	zassert_equal(pharos_device_restore(&device, now_us, 0, &lit), DEVICE_ACCEPTED);
	zassert_true(light->settings.enable);
	zassert_equal(light->settings.strobe_period_us, light->config.max_period_us);
}

ZTEST(core_device, test_without_servos_there_is_no_gimbal)
{
	start(&(struct device_config){.gimbal = false});
	zassert_false(pharos_device_has_gimbal(&device));
	EXPECT_REFUSED(DEVICE_ABSENT, pharos_device_point(&device, now_us, &mavlink, &right));
	EXPECT_REFUSED(DEVICE_ABSENT, pharos_device_follow(&device, now_us, &mavlink, &right));
	zassert_equal(pharos_device_deadline_us(&device), TIME_NEVER_US);
}

/* --- a group is all or none --------------------------------------------------------------------
 */

/* Any two to four commands: either each would be taken after those before it, and all are; or none
 * is. */
ZTEST(core_device, test_a_group_is_all_or_none)
{
	uint32_t applied = 0;
	uint32_t refused = 0;

	for (uint32_t seed = 1; seed <= 4000; seed++) {
		struct illuminator_event events[4];
		struct illuminator_outbox ignored;
		struct illuminator trial = *light;
		enum illuminator_result expected = ILLUMINATOR_ACCEPTED;
		uint32_t random = seed * 2654435761u;
		const size_t count = 2 + (random >> 30) % 3;

		report((random >> 20 & 7) == 0 ? THERMAL_STATE_SHUTDOWN : THERMAL_STATE_NORMAL,
		       THERMAL_SENSOR_OK);
		trial = *light;
		for (size_t i = 0; i < count; i++) {
			random = random * 1664525u + 1013904223u;
			events[i] = (random >> 31) != 0
			                    ? (random >> 30 & 1) != 0 ? on : off
			                    : (struct illuminator_event){
						      .kind = ILLUMINATOR_EVENT_BRIGHTNESS,
						      .brightness_ppm = (random >> 8) % 1200000u};
			if (expected == ILLUMINATOR_ACCEPTED) {
				expected = illuminator_step(&trial, now_us, &events[i], &ignored);
			}
		}
		(void)took();
		remember();

		const enum device_result result =
			pharos_device_apply(&device, now_us, &mavlink, 0, events, count);

		if (expected == ILLUMINATOR_ACCEPTED) {
			zassert_equal(result, DEVICE_ACCEPTED, "seed %u", seed);
			zassert_mem_equal(light, &trial, sizeof(trial));
			applied++;
		} else {
			zassert_equal(result,
			              expected == ILLUMINATOR_DENIED ? DEVICE_DENIED
			                                             : DEVICE_FAILED,
			              "seed %u", seed);
			zassert_true(is_unchanged(), "seed %u", seed);
			refused++;
		}
	}
	zassert_true(applied > 1000 && refused > 1000, "%u, %u", applied, refused);
}

/* --- effects -----------------------------------------------------------------------------------
 */

ZTEST(core_device, test_each_effect_is_told_once)
{
	zassert_false(took());
	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED);
	zassert_true(took());
	zassert_equal(effects.lights, 1);
	zassert_equal(effects.settings, 1);
	zassert_equal(effects.statuses, 1);
	zassert_equal(effects.reports, 0);
	zassert_true(param_set_is_empty(&effects.params));
	zassert_true(light->plan.on);
	zassert_false(took());

	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED);
	zassert_false(took(), "nothing is new");
}

ZTEST(core_device, test_effects_of_several_verbs_are_taken_together)
{
	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED);
	param_set(PARAM_LGT_CURVE, 0);
	param_set(PARAM_THR_HYST, param_get(PARAM_THR_HYST) + 1);
	report(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_FAILED);
	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	zassert_equal(give(&dronecan, &off), DEVICE_ACCEPTED);
	zassert_true(took());
	zassert_equal(effects.lights, 1);
	zassert_equal(effects.reports, 1);
	zassert_equal(effects.notices[0], 1u << ILLUMINATOR_NOTICE_SHUTDOWN |
	                                          1u << ILLUMINATOR_NOTICE_SENSOR_FAILED |
	                                          1u << ILLUMINATOR_NOTICE_RECOVERED |
	                                          1u << ILLUMINATOR_NOTICE_SENSOR_OK);
	zassert_equal(param_set_take(&effects.params), PARAM_LGT_CURVE);
	zassert_equal(param_set_take(&effects.params), PARAM_THR_HYST);
	zassert_true(param_set_is_empty(&effects.params));
	zassert_false(light->plan.on, "the last counts");
	zassert_false(took());
}

ZTEST(core_device, test_a_parameter_is_in_force_at_once)
{
	param_set(PARAM_STRB_MIN, 5000);
	zassert_equal(light->config.min_period_us, 5000);
	param_set(PARAM_LGT_SRC_HOLD, 1234);
	zassert_equal(device.lamps[0].arbiter.config.hold_us, 1234000);
	zassert_equal(device.gimbal_arbiter.config.hold_us, 1234000);
	param_set(PARAM_LGT_LOSS, 3000);
	zassert_equal(device.lamps[0].arbiter.config.loss_us, 3 * S);
	zassert_equal(device.gimbal_arbiter.config.loss_us, 0, "silence moves no gimbal");
	param_set(PARAM_GMB_PAN_RATE, 5000);
	zassert_equal(device.gimbal.config.axes[GIMBAL_PAN].rate_mdeg_per_s, 5000);
	param_set(PARAM_ESC_MAX, 1800);
	zassert_equal(device.actuators.thruster.config.max_us, 1800);
	pharos_device_reset_params(&device, now_us, &shell);
	zassert_equal(light->config.min_period_us, CONFIG_PHAROS_STROBE_PERIOD_MIN_US);
}

ZTEST(core_device, test_the_commander_is_a_parameter)
{
	zassert_equal(param_get(PARAM_LGT_SRC_NOW), ARBITER_SOURCE_NONE);
	zassert_equal(give(&dronecan, &on), DEVICE_ACCEPTED);
	zassert_equal(param_get(PARAM_LGT_SRC_NOW), ARBITER_SOURCE_DRONECAN);
	param_set(PARAM_LGT_FALLBACK, ILLUMINATOR_FALLBACK_OFF);
	param_set(PARAM_LGT_LOSS, 3000);
	zassert_equal(pharos_device_deadline_us(&device) <= 3 * S, true);
	now_us = 3 * S;
	pharos_device_step(&device, now_us);
	zassert_equal(param_get(PARAM_LGT_SRC_NOW), ARBITER_SOURCE_FALLBACK);
	zassert_false(light->settings.enable);
}

/* --- repetitions and following -----------------------------------------------------------------
 */

ZTEST(core_device, test_a_repetition_takes_the_device_from_nobody)
{
	zassert_equal(give(&repeating, &on), DEVICE_ACCEPTED, "nobody has it");
	zassert_equal(give(&repeating, &on), DEVICE_ACCEPTED, "its own");
	zassert_equal(give(&shell, &off), DEVICE_ACCEPTED);
	now_us = S;
	zassert_equal(give(&repeating, &on), DEVICE_KEPT);
	zassert_false(light->settings.enable);
	zassert_equal(device.lamps[0].arbiter.heard_us, S, "but it is there");
	zassert_equal(pharos_device_point(&device, now_us, &shell, &right), DEVICE_ACCEPTED);
	zassert_equal(pharos_device_point(&device, now_us, &repeating, &right), DEVICE_KEPT);
	zassert_equal(give(&dronecan, &on), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_an_aim_follows_only_its_commander)
{
	const struct gimbal_event left = {.kind = GIMBAL_EVENT_AIM,
	                                  .aim[GIMBAL_PAN] = {GIMBAL_ANGLE, false, -30000}};

	EXPECT_REFUSED(DEVICE_KEPT, pharos_device_follow(&device, now_us, &mavlink, &left));
	zassert_equal(pharos_device_point(&device, now_us, &mavlink, &right), DEVICE_ACCEPTED);
	now_us = S;
	zassert_equal(pharos_device_follow(&device, now_us, &mavlink, &left), DEVICE_ACCEPTED);
	zassert_equal(device.gimbal.axes[GIMBAL_PAN].aim_ndeg, INT64_C(-30000000000));
	zassert_equal(device.gimbal_arbiter.commanded_us, 0, "no command");
	zassert_equal(pharos_device_point(&device, now_us, &shell, &right), DEVICE_ACCEPTED);
	EXPECT_REFUSED(DEVICE_KEPT, pharos_device_follow(&device, now_us, &mavlink, &left));
}

/* --- self-test, power, servos ------------------------------------------------------------------
 */

ZTEST(core_device, test_a_self_test_runs_and_is_interrupted)
{
	enum self_test_state obstacle;

	EXPECT_REFUSED(DEVICE_FAILED,
	               pharos_device_test(&device, now_us, &shell, 0, PPM_ONE, &obstacle));
	zassert_equal(obstacle, SELF_TEST_SENSOR_FAILED);
	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	zassert_equal(pharos_device_test(&device, now_us, &shell, 0, PPM_ONE, &obstacle),
	              DEVICE_ACCEPTED);
	zassert_equal(obstacle, SELF_TEST_NONE);
	EXPECT_REFUSED(DEVICE_FAILED,
	               pharos_device_test(&device, now_us, &shell, 0, PPM_ONE, &obstacle));
	zassert_equal(obstacle, SELF_TEST_RUNNING);
	while (device.lamps[0].self_test.step < 5) {
		now_us = pharos_device_deadline_us(&device);
		pharos_device_step(&device, now_us);
	}
	zassert_true(light->plan.on);
	zassert_equal(give(&mavlink, &off), DEVICE_ACCEPTED);
	pharos_device_step(&device, now_us);
	zassert_equal(device.lamps[0].self_test.state, SELF_TEST_INTERRUPTED);
	EXPECT_REFUSED(false, pharos_device_cancel_test(&device, now_us, &shell, 0));
}

ZTEST(core_device, test_a_cancelled_self_test_leaves_the_lamp_as_it_was)
{
	enum self_test_state obstacle;

	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	pharos_device_report_driver(&device, 0, true);
	zassert_equal(pharos_device_test(&device, now_us, &shell, 0, 1, &obstacle), DEVICE_FAILED);
	zassert_equal(obstacle, SELF_TEST_DRIVER_FAILED);
	pharos_device_report_driver(&device, 0, false);
	zassert_equal(pharos_device_test(&device, now_us, &shell, 0, 1, &obstacle),
	              DEVICE_ACCEPTED);
	zassert_true(pharos_device_cancel_test(&device, now_us, &shell, 0));
	zassert_false(light->plan.on);
	zassert_equal(pharos_device_deadline_us(&device) >= now_us, true);
}

ZTEST(core_device, test_the_lamp_goes_out_with_its_power)
{
	const struct actuators_event restart = {.kind = ACTUATORS_EVENT_POWER,
	                                        .timed = {.op = POWER_OP_RESTART}};

	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED);
	(void)took();
	zassert_equal(pharos_device_output(&device, now_us, &dronecan, &restart), DEVICE_ACCEPTED);
	zassert_equal(device.lamps[0].arbiter.commander, ARBITER_SOURCE_DRONECAN);
	zassert_true(took());
	zassert_true(effects.outputs);
	zassert_equal(effects.lights, 1);
	zassert_false(light->settings.enable);
	zassert_equal(give(&mavlink, &on), DEVICE_FAILED);
	now_us = POWER_RESTART_US;
	pharos_device_step(&device, now_us);
	zassert_false(light->settings.enable, "dark until commanded");
	zassert_equal(give(&mavlink, &on), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_a_power_down_is_told_step_by_step)
{
	const struct actuators_event down = {
		.kind = ACTUATORS_EVENT_SHUTDOWN,
		.timed = {.op = SHUTDOWN_OP_DOWN, .us = 2 * S},
	};
	uint32_t told = 0;

	zassert_equal(pharos_device_output(&device, now_us, &shell, &down), DEVICE_ACCEPTED);
	for (int64_t left_us = 2 * S; left_us >= 0; left_us -= S) {
		now_us = 2 * S - left_us;
		pharos_device_step(&device, now_us);
		zassert_true(took());
		zassert_true(effects.has_shutdown);
		zassert_equal(effects.shutdown.op, SHUTDOWN_OP_DOWN_IN_PROGRESS);
		zassert_equal(effects.shutdown.remain_us, left_us);
		told++;
	}
	zassert_equal(told, 3);
	zassert_false(actuators_is_up(&device.actuators));
	pharos_device_step(&device, now_us + 60 * S);
	zassert_false(took() && effects.has_shutdown);
}

ZTEST(core_device, test_a_notice_waits_for_the_one_before_it)
{
	const struct actuators_event down = {.kind = ACTUATORS_EVENT_SHUTDOWN,
	                                     .timed = {.op = SHUTDOWN_OP_DOWN, .us = S}};
	const struct actuators_event abort = {.kind = ACTUATORS_EVENT_SHUTDOWN,
	                                      .timed = {.op = SHUTDOWN_OP_DOWN_ABORTED}};

	zassert_equal(pharos_device_output(&device, now_us, &shell, &down), DEVICE_ACCEPTED);
	zassert_equal(pharos_device_output(&device, now_us, &shell, &abort), DEVICE_ACCEPTED);
	zassert_true(took());
	zassert_equal(effects.shutdown.op, SHUTDOWN_OP_DOWN_IN_PROGRESS);
	zassert_true(pharos_device_deadline_us(&device) <= now_us, "it is to be called again");
	pharos_device_step(&device, now_us);
	zassert_true(took());
	zassert_true(effects.has_shutdown);
	zassert_equal(effects.shutdown.op, SHUTDOWN_OP_DOWN_ABORTED);
}

ZTEST(core_device, test_servos_are_moved_and_their_faults_are_news_once)
{
	pharos_device_step(&device, now_us);
	zassert_true(took());
	zassert_true(effects.move, "to neutral");
	zassert_equal(pharos_device_point(&device, now_us, &mavlink, &right), DEVICE_ACCEPTED);
	now_us = pharos_device_deadline_us(&device);
	pharos_device_step(&device, now_us);
	zassert_true(took());
	zassert_true(effects.move);
	zassert_true(pharos_device_report_servos(&device, now_us, true));
	zassert_false(pharos_device_report_servos(&device, now_us, true));
	zassert_true(device.gimbal.fault);
	zassert_true(pharos_device_report_servos(&device, now_us, false));
}

/* --- bugs --------------------------------------------------------------------------------------
 */

ZTEST(core_device, test_heat_is_no_command)
{
	const struct illuminator_event heat = {.kind = ILLUMINATOR_EVENT_THERMAL};

	expect_assert();
	(void)give(&mavlink, &heat);
	zassert_unreachable();
}

ZTEST(core_device, test_an_attitude_is_no_command)
{
	const struct gimbal_event attitude = {.kind = GIMBAL_EVENT_ATTITUDE};

	expect_assert();
	(void)pharos_device_point(&device, now_us, &mavlink, &attitude);
	zassert_unreachable();
}

ZTEST(core_device, test_a_lamp_that_there_is_not)
{
	expect_assert();
	(void)pharos_device_apply(&device, now_us, &mavlink, DEVICE_LAMPS_MAX, &on, 1);
	zassert_unreachable();
}

/* --- the security table ----------------------------------------------------------------------- */

/* Every verb asks: a way that may nothing changes nothing at all, and takes no command. */
ZTEST(core_device, test_who_may_not_changes_nothing_by_any_verb)
{
	static const enum security_way ways[] = {SECURITY_WAY_MAVLINK, SECURITY_WAY_DRONECAN,
	                                         SECURITY_WAY_IMC};
	const struct attitude attitude = {0};
	enum self_test_state obstacle;

	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	pharos_device_set_keyed(&device, now_us, true);
	(void)took();
	for (size_t i = 0; i < ARRAY_SIZE(ways); i++) {
		const struct device_who who = {.way = ways[i]};

		before_it = device;
		now_us += S;
		zassert_equal(give(&who, &on), DEVICE_EXCLUDED);
		zassert_equal(pharos_device_point(&device, now_us, &who, &right), DEVICE_EXCLUDED);
		zassert_equal(pharos_device_test(&device, now_us, &who, 0, PPM_ONE, &obstacle),
		              DEVICE_EXCLUDED);
		zassert_equal(pharos_device_set_param(&device, now_us, &who, PARAM_LGT_CURVE, 0),
		              PARAMS_FORBIDDEN);
		zassert_false(pharos_device_reset_params(&device, now_us, &who));
		pharos_device_heard(&device, now_us, &who);
		pharos_device_report_attitude(&device, now_us, &who, &attitude);
#ifdef CONFIG_PHAROS_IMC
		const struct actuators_event led = {.kind = ACTUATORS_EVENT_LED, .led = 10};

		zassert_equal(pharos_device_output(&device, now_us, &who, &led), DEVICE_EXCLUDED);
#endif
		zassert_mem_equal(&device, &before_it, sizeof(device));
	}
	zassert_equal(give(&shell, &on), DEVICE_ACCEPTED);
}

ZTEST(core_device, test_a_test_is_cancelled_by_who_may_light)
{
	enum self_test_state obstacle;

	report(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	zassert_equal(pharos_device_test(&device, now_us, &shell, 0, PPM_ONE, &obstacle),
	              DEVICE_ACCEPTED);
	param_set(PARAM_LGT_SRC_EXCL, 2); /* DroneCAN */
	zassert_false(pharos_device_cancel_test(&device, now_us, &dronecan, 0));
	zassert_true(pharos_device_cancel_test(&device, now_us, &mavlink, 0));
}

ZTEST(core_device, test_each_parameter_has_the_right_that_it_touches)
{
	zassert_equal(params_right(PARAM_LGT_SRC_EXCL), SECURITY_LOCK);
	zassert_equal(params_right(PARAM_MAV_SECURE), SECURITY_LOCK);
	zassert_equal(params_right(PARAM_MAV_KEY_CAN), SECURITY_LOCK);
#ifdef CONFIG_PHAROS_IMC
	zassert_equal(params_right(PARAM_MAV_KEY_IMC), SECURITY_LOCK);
	zassert_equal(params_right(PARAM_IMC_ID), SECURITY_SUPERVISION);
#endif
	zassert_equal(params_right(PARAM_THR_SHUTDOWN), SECURITY_SUPERVISION);
	zassert_equal(params_right(PARAM_LGT_SRC_PRIO), SECURITY_SUPERVISION);
	zassert_equal(params_right(PARAM_MAV_SYSID), SECURITY_SUPERVISION);
	zassert_equal(params_right(PARAM_CAN_NODE_ID), SECURITY_SUPERVISION);
	zassert_equal(params_right(PARAM_LGT_CURVE), SECURITY_PARAMS);
	zassert_equal(params_right(PARAM_SYNC_MODE), SECURITY_PARAMS);
	zassert_equal(params_right(PARAM_GMB_PAN_MAX), SECURITY_PARAMS);
}

/* Only who may everything resets everything: the lock is among it. */
ZTEST(core_device, test_a_reset_of_parameters_opens_no_lock)
{
	param_set(PARAM_MAV_KEY_CAN, SECURITY_GRANT_ALL);
	param_set(PARAM_LGT_SRC_EXCL, 4);
	pharos_device_set_keyed(&device, now_us, true);
	zassert_equal(pharos_device_set_param(&device, now_us, &dronecan, PARAM_LGT_CURVE, 0),
	              PARAMS_OK);
	zassert_false(pharos_device_reset_params(&device, now_us, &dronecan));
	zassert_equal(param_get(PARAM_LGT_SRC_EXCL), 4);
	zassert_true(pharos_device_reset_params(&device, now_us, &shell));
	zassert_equal(param_get(PARAM_LGT_SRC_EXCL), 0);
}
