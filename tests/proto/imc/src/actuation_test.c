/* SPDX-License-Identifier: Apache-2.0 */
/* The actuation group: what each message does, its answer, and what is refused. */
#include <string.h>

#include <zephyr/ztest.h>

#include "core/arbiter.h"
#include "peer.h"

/* Zephyr's minimal C library has neither. */
#undef NAN
#undef INFINITY
#define NAN      __builtin_nanf("")
#define INFINITY __builtin_inff()

#define S    INT64_C(1000000)
#define MDEG INT64_C(1000000) /* in 10^-9 degrees */

static struct illuminator *const light = &device.lamps[0].illuminator;
static struct arbiter *const arbiter = &device.lamps[0].arbiter;
static struct imc_actuation *const actuation = &endpoint.actuation;
static struct actuators_outputs outputs;

static const struct actuators_config full = {
	.power = 0x0F,
	.power_on = 0x07,
	.pwms = 0x03,
	.leds = 0x01,
	.gpio_outputs = 0x03,
	.gpio_inputs = 0x01,
	.thruster = true,
	.focus = true,
	.display = true,
};

static void start(const struct actuators_config *config, bool gimbal)
{
	const struct thruster_config thruster = {
		.min_us = 1000, .max_us = 2000, .arm_us = 0, .loss_us = S};
	struct gimbal_config axes;

	device_board = (struct device_config){.gimbal = gimbal, .actuators = *config};
	device_start(NULL);
	thruster_init(&device.actuators.thruster, 0, &thruster);
	focus_init(&device.actuators.focus, 4 * S);
	shutdown_init(&device.actuators.shutdown, 3 * S);
	device.actuators.config.thruster_config = thruster;
	params_gimbal(params, &axes);
	axes.axes[GIMBAL_PAN].rate_mdeg_per_s = 1000000; /* so that ppm of it are mdeg/s */
	axes.axes[GIMBAL_TILT].rate_mdeg_per_s = 1000000;
	gimbal_init(&device.gimbal, 0, &axes);
}

static void before(void *fixture)
{
	start(&full, true);
}

ZTEST_SUITE(imc_actuation, NULL, NULL, before, NULL, NULL);

static enum imc_actuation_outcome tell(struct imc_message message)
{
	send(&message);
	actuators_outputs(&device.actuators, &outputs);
	return actuation->refusal.outcome;
}

/* --- LEDs ------------------------------------------------------------------------------------- */

static enum imc_actuation_outcome set_led(const char *name, uint8_t value)
{
	return tell((struct imc_message){
		.id = IMC_SET_LED_BRIGHTNESS,
		.led_brightness = {.name = text(name), .value = value},
	});
}

static void expect_led(const char *name, uint8_t value)
{
	zassert_equal(count(IMC_LED_BRIGHTNESS), 1);
	const struct imc_packet *const packet = sent(IMC_LED_BRIGHTNESS, 0);

	zassert_equal(packet->header.dst, VEHICLE);
	zassert_equal(packet->header.dst_ent, 7, "the asker's entity");
	zassert_true(imc_text_is(&packet->message.led_brightness.name, name));
	zassert_equal(packet->message.led_brightness.value, value);
}

ZTEST(imc_actuation, test_every_brightness_of_the_lamp_comes_back_as_it_was_set)
{
	for (unsigned int value = 1; value <= 255; value++) {
		zassert_equal(set_led("lamp", (uint8_t)value), IMC_ACTUATION_DONE);
		expect_led("lamp", (uint8_t)value);
		zassert_true(light->settings.enable);
	}
	zassert_equal(light->settings.brightness_ppm, 1000000);
	zassert_equal(arbiter->commander, ARBITER_SOURCE_IMC);
	set_led("lamp", 0);
	expect_led("lamp", 0);
	zassert_false(light->settings.enable);
	zassert_equal(light->settings.brightness_ppm, 1000000, "off keeps the brightness");
}

ZTEST(imc_actuation, test_brightness_set_elsewhere_is_told)
{
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_RESTORE,
		.restore = {.enable = true,
	                    .mode = 1,
	                    .brightness_ppm = 400000,
	                    .duty_ppm = 1000000},
	};
	struct illuminator_outbox ignored;

	illuminator_step(light, 0, &event, &ignored);
	tell((struct imc_message){.id = IMC_QUERY_LED_BRIGHTNESS,
	                          .query_led_brightness = {.name = text("lamp")}});
	expect_led("lamp", 102); /* 0.4 * 255 */
}

ZTEST(imc_actuation, test_indicator_and_unknown_leds)
{
	zassert_equal(set_led("status", 77), IMC_ACTUATION_DONE);
	expect_led("status", 77);
	zassert_equal(outputs.leds[0], 77);
	zassert_equal(set_led("signal", 1), IMC_ACTUATION_UNKNOWN, "not on this board");
	zassert_equal(count(IMC_LED_BRIGHTNESS), 0);
	zassert_equal(set_led("Lamp", 1), IMC_ACTUATION_UNKNOWN);
	zassert_equal(set_led("", 1), IMC_ACTUATION_UNKNOWN);
	zassert_equal(actuation->stats.outcomes[IMC_ACTUATION_UNKNOWN], 3);
	set_led("a\nlong name \xff that is cut off", 1);
	zassert_equal(strcmp(actuation->refusal.name, "a?long name ? t"), 0);
}

ZTEST(imc_actuation, test_heat_and_the_arbiter_win_over_a_brightness)
{
	const struct illuminator_event hot = {
		.kind = ILLUMINATOR_EVENT_THERMAL,
		.thermal = {.state = THERMAL_STATE_SHUTDOWN},
	};
	struct illuminator_outbox ignored;

	device.security.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_IMC);
	zassert_equal(set_led("lamp", 50), IMC_ACTUATION_REFUSED);
	expect_led("lamp", 0);
	device.security.excluded = 0;
	zassert_equal(set_led("lamp", 50), IMC_ACTUATION_DONE);
	illuminator_step(light, 0, &hot, &ignored);
	tell((struct imc_message){.id = IMC_QUERY_LED_BRIGHTNESS,
	                          .query_led_brightness = {.name = text("lamp")}});
	expect_led("lamp", 0);
	zassert_equal(set_led("lamp", 60), IMC_ACTUATION_REFUSED);
	expect_led("lamp", 0);
}

/* --- PWM -------------------------------------------------------------------------------------- */

static enum imc_actuation_outcome set_pwm(uint8_t id, uint32_t period_us, uint32_t duty_us)
{
	return tell((struct imc_message){
		.id = IMC_SET_PWM,
		.pwm = {.id = id, .period = period_us, .duty_cycle = duty_us},
	});
}

ZTEST(imc_actuation, test_pwm_is_answered_with_the_same)
{
	zassert_equal(set_pwm(1, 20000, 1700), IMC_ACTUATION_DONE);
	const struct imc_pwm answer = sent(IMC_PWM, 0)->message.pwm;

	zassert_equal(answer.id, 1);
	zassert_equal(answer.period, 20000);
	zassert_equal(answer.duty_cycle, 1700);
	zassert_equal(outputs.pwms[0].period_us, 20000);
	zassert_equal(outputs.pwms[0].duty_us, 1700);
}

ZTEST(imc_actuation, test_pwm_that_cannot_be_has_no_answer)
{
	zassert_equal(set_pwm(1, 20000, 20001), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_pwm(1, 0, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_pwm(1, UINT32_MAX, 1), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_pwm(0, 0, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_pwm(0, 100, 101), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_pwm(0, 10000001, 1), IMC_ACTUATION_OUT_OF_RANGE, "no such strobe");
	zassert_equal(set_pwm(9, 100, 1), IMC_ACTUATION_UNKNOWN);
	zassert_equal(count(IMC_PWM), 0);
	zassert_false(light->settings.enable);
}

ZTEST(imc_actuation, test_slow_pwm_of_the_lamp_strobes_and_fast_one_dims)
{
	set_led("lamp", 51); /* 20 % */
	zassert_equal(set_pwm(0, 500000, 50000), IMC_ACTUATION_DONE);
	zassert_equal(light->settings.strobe_period_us, 500000);
	zassert_equal(light->plan.on_us, 50000);
	zassert_equal(light->settings.brightness_ppm, 200000);
	zassert_equal(set_pwm(0, 1000, 250), IMC_ACTUATION_DONE);
	zassert_equal(light->settings.strobe_period_us, 0);
	zassert_equal(light->settings.brightness_ppm, 250000);
	zassert_true(light->settings.enable);
	zassert_equal(set_pwm(0, 1000, 0), IMC_ACTUATION_DONE);
	zassert_false(light->settings.enable);
	zassert_equal(count(IMC_PWM), 1);
}

/* --- GPIO ------------------------------------------------------------------------------------- */

static enum imc_actuation_outcome set_gpio(const char *name, uint8_t value)
{
	return tell((struct imc_message){
		.id = IMC_GPIO_STATE_SET,
		.gpio_state = {.name = text(name), .value = value},
	});
}

ZTEST(imc_actuation, test_lines_are_set_and_read_by_name)
{
	zassert_equal(set_gpio("out1", 1), IMC_ACTUATION_DONE);
	zassert_equal(sent(IMC_GPIO_STATE, 0)->message.gpio_state.value, 1);
	zassert_equal(outputs.gpio_outputs, 0x02);
	actuation->gpio_inputs = 0x01;
	tell((struct imc_message){.id = IMC_GPIO_STATE_GET,
	                          .gpio_state_get = {.name = text("in0")}});
	zassert_true(imc_text_is(&sent(IMC_GPIO_STATE, 0)->message.gpio_state.name, "in0"));
	zassert_equal(sent(IMC_GPIO_STATE, 0)->message.gpio_state.value, 1);
	zassert_equal(set_gpio("in0", 0), IMC_ACTUATION_REFUSED);
	zassert_equal(sent(IMC_GPIO_STATE, 0)->message.gpio_state.value, 1, "as it is");
	zassert_equal(set_gpio("out1", 2), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(count(IMC_GPIO_STATE), 0);
	zassert_equal(set_gpio("in1", 1), IMC_ACTUATION_UNKNOWN, "not on this board");
	zassert_equal(outputs.gpio_outputs, 0x02);
}

/* --- servos and motors ------------------------------------------------------------------------ */

static enum imc_actuation_outcome set_servo(uint16_t message, uint8_t id, float angle_rad)
{
	struct imc_message servo = {.id = message};

	if (message == IMC_SET_SERVO_POSITION) {
		servo.set_servo_position =
			(struct imc_set_servo_position){.id = id, .value = angle_rad};
	} else {
		servo.set_control_surface_deflection =
			(struct imc_set_control_surface_deflection){.id = id, .angle = angle_rad};
	}
	return tell(servo);
}

ZTEST(imc_actuation, test_servos_turn_the_gimbal_and_auxiliary_outputs)
{
	const struct gimbal_axis *const axes = device.gimbal.axes;

	/* pi / 6 is 30 degrees */
	zassert_equal(set_servo(IMC_SET_SERVO_POSITION, 0, 0.5235988f), IMC_ACTUATION_DONE);
	zassert_equal(axes[GIMBAL_PAN].kind, GIMBAL_ANGLE);
	zassert_equal(axes[GIMBAL_PAN].aim_ndeg, 30000 * MDEG);
	zassert_equal(axes[GIMBAL_TILT].aim_ndeg, 0);
	zassert_equal(set_servo(IMC_SET_CONTROL_SURFACE_DEFLECTION, 1, -1.5707964f),
	              IMC_ACTUATION_DONE);
	zassert_equal(axes[GIMBAL_TILT].aim_ndeg, -90000 * MDEG);
	zassert_equal(axes[GIMBAL_PAN].aim_ndeg, 30000 * MDEG);
	zassert_equal(set_servo(IMC_SET_SERVO_POSITION, 3, 1.5707964f), IMC_ACTUATION_DONE);
	zassert_equal(outputs.pwms[1].period_us, 20000);
	zassert_equal(outputs.pwms[1].duty_us, 2000);
	/* half a turn is for the gimbal only */
	zassert_equal(set_servo(IMC_SET_CONTROL_SURFACE_DEFLECTION, 0, 3.1415927f),
	              IMC_ACTUATION_DONE);
	zassert_equal(set_servo(IMC_SET_CONTROL_SURFACE_DEFLECTION, 3, 3.1415927f),
	              IMC_ACTUATION_OUT_OF_RANGE);
}

ZTEST(imc_actuation, test_angles_that_are_none_are_refused)
{
	static const float bad[] = {NAN, INFINITY, -INFINITY, 1.58f, -1.58f, 1e30f};

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(set_servo(IMC_SET_SERVO_POSITION, 0, bad[i]),
		              IMC_ACTUATION_OUT_OF_RANGE, "row %zu", i);
	}
	zassert_equal(set_servo(IMC_SET_CONTROL_SURFACE_DEFLECTION, 0, NAN),
	              IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_servo(IMC_SET_CONTROL_SURFACE_DEFLECTION, 0, 3.15f),
	              IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_servo(IMC_SET_SERVO_POSITION, 4, 0), IMC_ACTUATION_UNKNOWN);
	start(&full, false);
	zassert_equal(set_servo(IMC_SET_SERVO_POSITION, 0, 0), IMC_ACTUATION_UNKNOWN,
	              "no gimbal here");
}

static enum imc_actuation_outcome set_thruster(uint8_t id, float value)
{
	return tell((struct imc_message){
		.id = IMC_SET_THRUSTER_ACTUATION,
		.set_thruster_actuation = {.id = id, .value = value},
	});
}

ZTEST(imc_actuation, test_thruster_goes_back_to_neutral)
{
	zassert_equal(set_thruster(0, -0.5f), IMC_ACTUATION_DONE);
	zassert_equal(outputs.thruster_pulse_us, 1250);
	zassert_equal(set_thruster(0, NAN), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_thruster(0, 1.001f), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(set_thruster(1, 0), IMC_ACTUATION_UNKNOWN);
	zassert_equal(outputs.thruster_pulse_us, 1250);
	pass(S - 1, 0);
	zassert_equal(thruster_pulse_us(&device.actuators.thruster), 1250);
	pass(S, 0);
	zassert_equal(thruster_pulse_us(&device.actuators.thruster), 1500);
}

static enum imc_actuation_outcome zoom(uint8_t id, uint8_t action, uint8_t level)
{
	return tell((struct imc_message){
		.id = IMC_CAMERA_ZOOM,
		.camera_zoom = {.id = id, .zoom = level, .action = action},
	});
}

ZTEST(imc_actuation, test_zoom_of_the_beam)
{
	zassert_equal(zoom(0, IMC_ZOOM_IN, 0), IMC_ACTUATION_DONE);
	zassert_equal(outputs.focus, FOCUS_MOTOR_IN);
	pass(1 * S, 0);
	zassert_equal(zoom(0, IMC_ZOOM_STOP, 200), IMC_ACTUATION_DONE, "a stop has no level");
	zassert_equal(outputs.focus, FOCUS_MOTOR_STOPPED);
	zassert_equal(focus_position_ppm(&device.actuators.focus, now_us), 250000);
	zassert_equal(zoom(0, IMC_ZOOM_IN, 153), IMC_ACTUATION_DONE); /* 60 % */
	pass(5 * S, 0);
	zassert_equal(focus_position_ppm(&device.actuators.focus, now_us), 600000);
	zassert_equal(zoom(0, IMC_ZOOM_RESET, 0), IMC_ACTUATION_DONE);
	zassert_equal(outputs.focus, FOCUS_MOTOR_OUT);
	zassert_equal(zoom(0, 4, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(zoom(1, IMC_ZOOM_IN, 0), IMC_ACTUATION_UNKNOWN);
}

/* --- power ------------------------------------------------------------------------------------ */

static enum imc_actuation_outcome channel(const char *name, uint8_t op, double sched_time)
{
	return tell((struct imc_message){
		.id = IMC_POWER_CHANNEL_CONTROL,
		.power_channel_control = {.name = text(name), .op = op, .sched_time = sched_time},
	});
}

ZTEST(imc_actuation, test_channels_are_all_told_to_the_asker)
{
	static const char *const names[] = {"lamp", "gimbal", "camera", "aux"};
	static const uint8_t states[] = {1, 1, 1, 0};

	tell((struct imc_message){.id = IMC_QUERY_POWER_CHANNEL_STATE});
	zassert_equal(count(IMC_POWER_CHANNEL_STATE), 4);
	for (uint32_t i = 0; i < 4; i++) {
		const struct imc_packet *const packet = sent(IMC_POWER_CHANNEL_STATE, i);

		zassert_equal(packet->header.dst, VEHICLE);
		zassert_true(imc_text_is(&packet->message.power_channel_state.name, names[i]));
		zassert_equal(packet->message.power_channel_state.state, states[i]);
	}
}

ZTEST(imc_actuation, test_channel_commands_and_schedules)
{
	zassert_equal(channel("aux", IMC_CHANNEL_TOGGLE, 0), IMC_ACTUATION_DONE);
	zassert_equal(outputs.power, 0x0F);
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_OFF, 1.5), IMC_ACTUATION_DONE);
	zassert_equal(actuators_deadline_us(&device.actuators), 1500000);
	zassert_equal(channel("camera", IMC_CHANNEL_RESET_SCHEDULES, NAN), IMC_ACTUATION_DONE);
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_ON, NAN), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_ON, -1.0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_ON, INFINITY),
	              IMC_ACTUATION_OUT_OF_RANGE);
	/* Unix time is no time from now */
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_ON, 1795000000.0),
	              IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(actuators_deadline_us(&device.actuators), TIME_NEVER_US);
	zassert_equal(channel("camera", IMC_CHANNEL_SCHEDULE_ON, 31536000.0), IMC_ACTUATION_DONE);
	zassert_equal(actuators_deadline_us(&device.actuators), 31536000 * S);
	zassert_equal(channel("camera", 8, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(channel("lights", IMC_CHANNEL_ON, 0), IMC_ACTUATION_UNKNOWN);
}

ZTEST(imc_actuation, test_lamp_goes_out_with_its_power)
{
	set_led("lamp", 255);
	zassert_equal(channel("lamp", IMC_CHANNEL_RESTART, 0), IMC_ACTUATION_DONE);
	zassert_false(light->settings.enable);
	zassert_equal(effects.lights, 1);
	zassert_equal(set_led("lamp", 255), IMC_ACTUATION_REFUSED);
	pass(2 * S, 0);
	zassert_equal(power_outputs(&device.actuators.power), 0x07);
	zassert_false(light->settings.enable, "dark until commanded");
	zassert_equal(set_led("lamp", 255), IMC_ACTUATION_DONE);
	arbiter_configure(arbiter,
	                  &(struct arbiter_config){.priority = ARBITER_SOURCE_SHELL, .hold_us = S});
	arbiter_commit(arbiter, now_us, ARBITER_SOURCE_SHELL);
	zassert_equal(channel("lamp", IMC_CHANNEL_OFF, 0), IMC_ACTUATION_REFUSED);
	zassert_equal(channel("camera", IMC_CHANNEL_OFF, 0), IMC_ACTUATION_DONE);
	zassert_true(light->settings.enable);
}

static enum imc_actuation_outcome power(uint8_t op, float remain_s, double sched_s)
{
	return tell((struct imc_message){
		.id = IMC_POWER_OPERATION,
		.power_operation = {.op = op, .time_remain = remain_s, .sched_time = sched_s},
	});
}

static void expect_notice(uint8_t op, float remain_s)
{
	zassert_equal(count(IMC_POWER_OPERATION), 1);
	const struct imc_packet *const packet = sent(IMC_POWER_OPERATION, 0);

	zassert_equal(sent_to(IMC_POWER_OPERATION, 0)->to, IMC_TO_PEERS);
	zassert_equal(packet->header.dst, IMC_DST_ALL);
	zassert_equal(packet->message.power_operation.op, op);
	zassert_equal(packet->message.power_operation.time_remain, remain_s);
}

ZTEST(imc_actuation, test_power_down_is_announced_and_then_happens)
{
	set_led("lamp", 255);
	zassert_equal(power(IMC_POWER_DOWN, 0, 0), IMC_ACTUATION_DONE);
	expect_notice(IMC_POWER_DOWN_IN_PROGRESS, 3.0f);
	zassert_equal(pass(2999999, IMC_POWER_OPERATION), 2);
	zassert_true(light->settings.enable);
	zassert_equal(pass(3 * S, IMC_POWER_OPERATION), 1);
	expect_notice(IMC_POWER_DOWN_IN_PROGRESS, 0.0f);
	zassert_false(light->settings.enable);
	zassert_equal(power_outputs(&device.actuators.power), 0);
	zassert_equal(set_led("status", 1), IMC_ACTUATION_REFUSED);
	tell((struct imc_message){.id = IMC_QUERY_POWER_CHANNEL_STATE});
	zassert_equal(sent(IMC_POWER_CHANNEL_STATE, 0)->message.power_channel_state.state, 0);
	zassert_equal(power(IMC_POWER_UP, 0, 0), IMC_ACTUATION_DONE);
	expect_notice(IMC_POWER_UP_IN_PROGRESS, 0.0f);
	zassert_equal(power_outputs(&device.actuators.power), 0x07);
	zassert_equal(set_led("lamp", 1), IMC_ACTUATION_DONE);
}

ZTEST(imc_actuation, test_power_down_is_aborted)
{
	zassert_equal(power(IMC_POWER_DOWN, 2.5f, 0), IMC_ACTUATION_DONE);
	expect_notice(IMC_POWER_DOWN_IN_PROGRESS, 2.5f);
	zassert_equal(power(IMC_POWER_DOWN_ABORTED, 0, 0), IMC_ACTUATION_DONE);
	expect_notice(IMC_POWER_DOWN_ABORTED, 0.0f);
	zassert_equal(pass(60 * S, IMC_POWER_OPERATION), 0);
}

ZTEST(imc_actuation, test_power_operations_out_of_range)
{
	zassert_equal(power(IMC_POWER_DOWN, NAN, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(IMC_POWER_DOWN, -1, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(IMC_POWER_DOWN, 3601, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(IMC_POWER_SCHEDULE_DOWN, 0, NAN), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(IMC_POWER_SCHEDULE_UP, 0, -1), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(7, 0, 0), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(power(IMC_POWER_DOWN_IN_PROGRESS, 5, 0), IMC_ACTUATION_DONE);
	header.dst_ent = IMC_ENTITY_LAMP;
	zassert_equal(power(IMC_POWER_DOWN, 0, 0), IMC_ACTUATION_UNKNOWN, "the lamp's alone");
	zassert_equal(pass(60 * S, IMC_POWER_OPERATION), 0);
	header.dst_ent = IMC_ENTITY_SYSTEM;
	zassert_equal(power(IMC_POWER_SCHEDULE_DOWN, 0, 5), IMC_ACTUATION_DONE);
	zassert_equal(actuators_deadline_us(&device.actuators), now_us + 5 * S);
}

/* --- panel ------------------------------------------------------------------------------------ */

ZTEST(imc_actuation, test_display)
{
	struct imc_message lcd = {.id = IMC_LCD_CONTROL,
	                          .lcd_control = {.op = IMC_LCD_WRITE1, .text = text("hello")}};

	zassert_equal(tell(lcd), IMC_ACTUATION_DONE);
	zassert_mem_equal(outputs.display.lines[1], "hello           ", DISPLAY_COLUMNS);
	lcd.lcd_control.op = IMC_LCD_ON;
	zassert_equal(tell(lcd), IMC_ACTUATION_DONE);
	zassert_true(outputs.display.on);
	lcd.lcd_control.op = 5;
	zassert_equal(tell(lcd), IMC_ACTUATION_OUT_OF_RANGE);
}

ZTEST(imc_actuation, test_buttons_are_told_to_everyone)
{
	imc_endpoint_button(&endpoint, now_us, 0, true, &out);
	zassert_equal(sent_to(IMC_BUTTON_EVENT, 0)->to, IMC_TO_PEERS);
	zassert_equal(sent(IMC_BUTTON_EVENT, 0)->message.button_event.value, 1);
	imc_endpoint_button(&endpoint, now_us, 0, false, &out);
	zassert_equal(sent(IMC_BUTTON_EVENT, 0)->message.button_event.value, 0);
}

static enum imc_actuation_outcome remote(const char *actions)
{
	return tell((struct imc_message){.id = IMC_REMOTE_ACTIONS,
	                                 .remote_actions = {.actions = text(actions)}});
}

static void request(uint8_t op, const char *actions)
{
	tell((struct imc_message){
		.id = IMC_REMOTE_ACTIONS_REQUEST,
		.remote_actions_request = {.op = op, .actions = text(actions)},
	});
}

ZTEST(imc_actuation, test_remote_report_says_what_there_is_and_in_which_range)
{
	request(IMC_REMOTE_ACTIONS_QUERY, "");
	zassert_equal(sent(IMC_REMOTE_ACTIONS_REQUEST, 0)->message.remote_actions_request.op, 0);
	zassert_true(imc_text_is(
		&sent(IMC_REMOTE_ACTIONS_REQUEST, 0)->message.remote_actions_request.actions,
		"Light=Button;Strobe=Button;Brightness=Slider;Pan=Axis;Tilt=Axis;Ranges=Range127"));
	request(IMC_REMOTE_ACTIONS_REGISTER, "Ranges=Decimal");
	zassert_equal(count(IMC_REMOTE_ACTIONS_REQUEST), 0);
	start(&full, false);
	request(IMC_REMOTE_ACTIONS_REGISTER, "Joy=Axis;Ranges=Decimal");
	request(IMC_REMOTE_ACTIONS_QUERY, "");
	zassert_true(imc_text_is(
		&sent(IMC_REMOTE_ACTIONS_REQUEST, 0)->message.remote_actions_request.actions,
		"Light=Button;Strobe=Button;Brightness=Slider;Ranges=Decimal"));
}

ZTEST(imc_actuation, test_remote_buttons_slider_and_axes)
{
	const struct gimbal_axis *const axes = device.gimbal.axes;

	zassert_equal(remote("Light=1;Brightness=64; Pan=-127;Other=x"), IMC_ACTUATION_DONE);
	zassert_true(light->settings.enable);
	zassert_equal(light->settings.brightness_ppm, 503937); /* 64 / 127 */
	zassert_equal(axes[GIMBAL_PAN].kind, GIMBAL_RATE);
	zassert_equal(axes[GIMBAL_PAN].rate, -1000000);
	zassert_equal(axes[GIMBAL_TILT].rate, 0);
	zassert_equal(remote("Strobe=127,Tilt=1"), IMC_ACTUATION_DONE);
	zassert_true(light->settings.enable, "a release is nothing");
	zassert_equal(light->settings.strobe_period_us, 500000);
	zassert_equal(light->settings.duty_ppm, 500000);
	zassert_equal(axes[GIMBAL_PAN].rate, 0);
	zassert_equal(axes[GIMBAL_TILT].rate, 7874);
	zassert_equal(remote(""), IMC_ACTUATION_DONE);
	zassert_equal(remote("Strobe=1"), IMC_ACTUATION_DONE);
	zassert_equal(light->settings.strobe_period_us, 0);
	zassert_equal(light->settings.brightness_ppm, 503937);
}

ZTEST(imc_actuation, test_remote_silence_stops_the_axes_after_a_second)
{
	zassert_equal(remote("Light=1;Pan=127"), IMC_ACTUATION_DONE);
	pass(S - 1, 0);
	zassert_equal(device.gimbal.axes[GIMBAL_PAN].rate, 1000000);
	pass(S, 0);
	zassert_equal(device.gimbal.axes[GIMBAL_PAN].kind, GIMBAL_RATE);
	zassert_equal(device.gimbal.axes[GIMBAL_PAN].rate, 0);
	zassert_true(light->settings.enable, "the lamp stays as it was toggled");
}

ZTEST(imc_actuation, test_remote_values_that_are_none_are_refused)
{
	static const char *const bad[] = {
		"Pan=128",  "Pan=-127.5", "Brightness=-1", "Light=", "Light",      "Light=on",
		"Tilt=nan", "Pan=1e2",    "Pan=99999999",  "Tilt=-", "Tilt=1.2.3", "Tilt=.",
	};

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(remote(bad[i]), IMC_ACTUATION_OUT_OF_RANGE, "%s", bad[i]);
	}
	zassert_equal(remote("Pan=1.5;Ranges=Decimal"), IMC_ACTUATION_OUT_OF_RANGE);
	zassert_equal(remote("Pan=-.25"), IMC_ACTUATION_DONE);
	zassert_equal(device.gimbal.axes[GIMBAL_PAN].rate, -250000);
	zassert_equal(remote("Brightness=1.0;Ranges=Decimal"), IMC_ACTUATION_DONE);
	zassert_equal(light->settings.brightness_ppm, 1000000);
}

/* --- a board that has none of it -------------------------------------------------------------- */

ZTEST(imc_actuation, test_bare_board_has_its_lamp)
{
	static const struct actuators_config bare = {
		.focus_travel_us = 1,
		.thruster_config = {.min_us = 1000, .max_us = 2000, .loss_us = 1},
	};

	start(&bare, false);
	zassert_equal(set_led("lamp", 9), IMC_ACTUATION_DONE);
	zassert_equal(set_pwm(0, 1000, 1), IMC_ACTUATION_DONE);
	zassert_equal(set_pwm(1, 1000, 1), IMC_ACTUATION_UNKNOWN);
	zassert_equal(set_thruster(0, 0), IMC_ACTUATION_UNKNOWN);
	zassert_equal(zoom(0, IMC_ZOOM_IN, 0), IMC_ACTUATION_UNKNOWN);
	zassert_equal(channel("lamp", IMC_CHANNEL_ON, 0), IMC_ACTUATION_UNKNOWN);
	zassert_equal(set_gpio("out0", 1), IMC_ACTUATION_UNKNOWN);
	tell((struct imc_message){.id = IMC_QUERY_POWER_CHANNEL_STATE});
	zassert_equal(count(IMC_POWER_CHANNEL_STATE), 0);
	zassert_equal(power(IMC_POWER_DOWN, 1, 0), IMC_ACTUATION_DONE);
	pass(1 * S, 0);
	zassert_false(light->settings.enable, "the lamp goes down without a switch");
	zassert_equal(set_led("lamp", 9), IMC_ACTUATION_REFUSED);
}
