/* SPDX-License-Identifier: Apache-2.0 */
/* Plain DroneCAN control. Specs: the uavcan.equipment types; dronecan.md, "Node". */
#include "device.h"

static struct dronecan_transfer heard;
static uint8_t ids; /* transfer ids: each command is a new transfer */

#define NDEG_PER_MDEG INT64_C(1000000)

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	device_start(NODE, false);
	ids = 0;
}

ZTEST_SUITE(dronecan_lights, NULL, NULL, before, NULL, NULL);

static struct illuminator *const lamp = &core.lamps[0].illuminator;
static struct dronecan_lights *const lights = &device.lights;

/* How many commands of the message were carried out, or would have been. */
static uint32_t give(struct dronecan_frame frame)
{
	const uint32_t before = lights->stats.applied + lights->stats.kept;

	frame.data[frame.size - 1u] = (uint8_t)(0xC0u | ids++);
	dronecan_endpoint_receive(&device, 0, &frame, &device_out);
	return lights->stats.applied + lights->stats.kept - before;
}

static void expect_brightness(uint32_t given, uint32_t brightness_ppm)
{
	zassert_equal(given, 1);
	zassert_equal(lamp->settings.brightness_ppm, brightness_ppm, "%u",
	              lamp->settings.brightness_ppm);
	zassert_true(lamp->settings.enable);
}

static void expect_on_off(uint32_t given, bool on)
{
	zassert_equal(given, 1);
	zassert_equal(lamp->settings.enable, on);
}

/* LightsCommand of one light: id, then red:5 green:6 blue:5. */
static struct dronecan_frame light(uint8_t id, unsigned int red, unsigned int green,
                                   unsigned int blue)
{
	const unsigned int color = (red << 11) | (green << 5) | blue;

	return FRAME(0x1804390A, id, (uint8_t)(color >> 8), (uint8_t)color, 0);
}

ZTEST(dronecan_lights, test_golden_lights_command_is_full_brightness)
{
	/* LightsCommand 254, full (dronecan.md, "Golden frames"). */
	expect_brightness(give(FRAME(0x1804390A, 0xFE, 0xFF, 0xFF, 0xC0)), PPM_ONE);
}

ZTEST(dronecan_lights, test_brightness_is_the_largest_of_the_colours)
{
	expect_brightness(give(light(254, 10, 0, 0)), 322581); /* 10/31 */
	expect_brightness(give(light(254, 0, 10, 0)), 158730); /* 10/63 */
	expect_brightness(give(light(254, 0, 0, 1)), 32258);   /* 1/31 */
	expect_brightness(give(light(254, 10, 63, 5)), PPM_ONE);
	expect_brightness(give(light(254, 15, 31, 0)), 492063); /* 31/63 > 15/31 */
	expect_on_off(give(light(254, 0, 0, 0)), false);
}

ZTEST(dronecan_lights, test_off_keeps_the_brightness)
{
	expect_brightness(give(light(254, 10, 0, 0)), 322581);
	expect_on_off(give(light(254, 0, 0, 0)), false);
	zassert_equal(lamp->settings.brightness_ppm, 322581);
	expect_on_off(give(FRAME(0x18042E0A, 0x00, 0x01, 0x00, 0xC0)), true);
	zassert_equal(lamp->settings.brightness_ppm, 322581);
}

ZTEST(dronecan_lights, test_other_light_ids_are_ignored)
{
	/* ArduPilot's own status colour has id 0. */
	zassert_equal(give(light(0, 31, 63, 31)), 0);
	zassert_equal(give(light(246, 31, 63, 31)), 0);
	device.lights.config.light_id = 0;
	expect_brightness(give(light(0, 31, 63, 31)), PPM_ONE);
	device.lights.config.light_id = DRONECAN_LIGHTS_ID_NONE;
	zassert_equal(give(light(255, 31, 63, 31)), 0);
}

ZTEST(dronecan_lights, test_our_light_among_others)
{
	expect_brightness(give(FRAME(0x1804390A, 0x00, 0x00, 0x00, 0xFE, 0xFF, 0xFF, 0x00)),
	                  PPM_ONE);
	/* Named twice: the last holds. */
	expect_on_off(give(FRAME(0x1804390A, 0xFE, 0xFF, 0xFF, 0xFE, 0x00, 0x00, 0x00)), false);
}

ZTEST(dronecan_lights, test_golden_hardpoint_is_on)
{
	/* hardpoint 0 on (dronecan.md, "Golden frames"). */
	expect_on_off(give(FRAME(0x18042E0A, 0x00, 0x01, 0x00, 0xC0)), true);
	expect_on_off(give(FRAME(0x18042E0A, 0x00, 0x00, 0x00, 0xC0)), false);
	expect_on_off(give(FRAME(0x18042E0A, 0x00, 0x00, 0x80, 0xC0)), true);
	zassert_equal(give(FRAME(0x18042E0A, 0x01, 0x01, 0x00, 0xC0)), 0);
}

ZTEST(dronecan_lights, test_golden_actuator_is_three_quarters_of_brightness)
{
	/* actuator 9 = +0.5 of -1…1 (dronecan.md, "Golden frames"). */
	expect_brightness(give(FRAME(0x0803F20A, 0x09, 0x00, 0x00, 0x38, 0xC0)), 750000);
}

static uint32_t actuate(uint8_t id, uint8_t type, uint16_t half)
{
	return give(FRAME(0x0803F20A, id, type, (uint8_t)half, (uint8_t)(half >> 8), 0));
}

ZTEST(dronecan_lights, test_unitless_brightness)
{
	expect_on_off(actuate(9, 0, 0xBC00), false); /* -1 */
	expect_brightness(actuate(9, 0, 0x0000), 500000);
	expect_brightness(actuate(9, 0, 0x3C00), PPM_ONE); /* 1 */
	expect_brightness(actuate(9, 0, 0x4000), PPM_ONE); /* 2: the end */
	expect_on_off(actuate(9, 0, 0xC000), false);       /* -2 */
}

ZTEST(dronecan_lights, test_pulses_are_of_type_4)
{
	expect_on_off(actuate(9, 4, 0x63D0), false);       /* 1000 us */
	expect_brightness(actuate(9, 4, 0x65DC), 500000);  /* 1500 us */
	expect_brightness(actuate(9, 4, 0x67D0), PPM_ONE); /* 2000 us */
	expect_brightness(actuate(9, 4, 0x6834), PPM_ONE); /* 2152 us */
	zassert_equal(actuate(9, 4, 0x0000), 0);           /* 0 us: no signal */
	zassert_equal(actuate(9, 4, 0x6A00), 0);           /* 3072 us */
	zassert_equal(device.lights.stats.refused, 2);
}

ZTEST(dronecan_lights, test_what_is_no_number_is_refused_and_counted)
{
	static const uint16_t bad[] = {0x7E00, 0x7C00, 0xFC00, 0xFFFF, 0x7C01};
	uint32_t refused = 0;

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(actuate(9, 0, bad[i]), 0);
		zassert_equal(actuate(9, 4, bad[i]), 0);
		zassert_equal(actuate(10, 0, bad[i]), 0);
		refused += 3;
		zassert_equal(device.lights.stats.refused, refused);
	}
	for (uint8_t type = 1; type < 255; type++) {
		if (type != 4) {
			zassert_equal(actuate(9, type, 0x3800), 0, "type %u", type);
		}
	}
	zassert_equal(device.lights.stats.commands, 0);
}

ZTEST(dronecan_lights, test_pan_and_tilt_beside_brightness)
{
	static const uint8_t data[] = {
		10, 0, 0x00, 0x38, /* pan +0.5 */
		11, 4, 0x18, 0x65, /* tilt 1304 us: -0.392 */
		3,  0, 0x00, 0x7E, /* somebody else's, no number */
		9,  0, 0x00, 0x00, /* brightness 0 of -1…1 */
	};

	tool_sends(0, &dronecan_actuator_array_command_type, DRONECAN_MESSAGE, data, sizeof(data));
	zassert_equal(lights->stats.applied, 3);
	zassert_equal(core.gimbal.axes[GIMBAL_PAN].aim_ndeg,
	              NDEG_PER_MDEG * gimbal_share_mdeg(&core.gimbal, GIMBAL_PAN, 500000));
	zassert_within(core.gimbal.axes[GIMBAL_TILT].aim_ndeg,
	               NDEG_PER_MDEG * gimbal_share_mdeg(&core.gimbal, GIMBAL_TILT, -392000),
	               NDEG_PER_MDEG);
	zassert_equal(lamp->settings.brightness_ppm, 500000);
	zassert_equal(device.lights.stats.refused, 0);
}

/* Whether it would take the lamp from the shell, which has commanded it in between. */
static bool takes(struct dronecan_frame frame)
{
	const struct device_who shell = {.way = SECURITY_WAY_SHELL};
	const struct illuminator_event off = {.kind = ILLUMINATOR_EVENT_ON_OFF};
	const uint32_t kept = lights->stats.kept;

	zassert_equal(pharos_device_apply(&core, 0, &shell, 0, &off, 1), DEVICE_ACCEPTED);
	zassert_equal(give(frame), 1);
	zassert_equal(core.lamps[0].arbiter.heard_us, 0);
	zassert_equal(lamp->settings.enable, lights->stats.kept == kept);
	return lights->stats.kept == kept;
}

/* A vehicle repeats at 50 Hz: that must not take the light back from another commander. */
ZTEST(dronecan_lights, test_repetitions_take_the_light_from_nobody)
{
	const struct dronecan_frame full = FRAME(0x0803F20A, 9, 0, 0x00, 0x3C, 0);

	zassert_true(takes(light(254, 10, 0, 0)));
	zassert_false(takes(light(254, 10, 0, 0)));
	zassert_true(takes(full), "another source");
	zassert_false(takes(light(254, 10, 0, 0)));
	zassert_true(takes(light(254, 11, 0, 0)));
	zassert_true(takes(FRAME(0x1804390A, 0xFE, 0xF8, 0x00, 0xFE, 0xF8, 0x00, 0)),
	             "new, though named twice");
	give(light(254, 11, 0, 0));
	zassert_false(takes(light(254, 11, 0, 0)));
}

/* One that was refused has had no effect: it is new when it comes again. */
ZTEST(dronecan_lights, test_a_refused_command_is_new_when_it_comes_again)
{
	core.security.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_DRONECAN);
	zassert_equal(give(light(254, 11, 0, 0)), 0);
	zassert_equal(lights->stats.rejected, 1);
	core.security.excluded = 0;
	zassert_true(takes(light(254, 11, 0, 0)));
}

ZTEST(dronecan_lights, test_malformed_commands_are_counted)
{
	zassert_equal(give(FRAME(0x1804390A, 0xFE, 0xFF, 0xC0)), 0);       /* a part */
	zassert_equal(give(FRAME(0x18042E0A, 0x00, 0x01, 0xC0)), 0);       /* short */
	zassert_equal(give(FRAME(0x0803F20A, 0x09, 0x00, 0x00, 0xC0)), 0); /* a part */
	zassert_equal(device.lights.stats.malformed, 3);
}

static void report(int64_t now_us, bool enable)
{
	memset(lamp, 0, sizeof(*lamp));
	lamp->settings.enable = enable;
	lamp->thermal.limit_ppm = PPM_ONE;
	lamp->thermal.temp_valid = true;
	lamp->thermal.temp_mdegc = 26850; /* 300 K */
	lamp->thermal.state = THERMAL_STATE_THROTTLING;
	dronecan_endpoint_report(&device, now_us);
}

ZTEST(dronecan_lights, test_hardpoint_status_is_told_each_second_and_on_change)
{
	report(0, false);
	device_step(0);
	zassert_true(tool_hears(0, &dronecan_hardpoint_status_type, &heard));
	zassert_equal(heard.data[0], 0);
	zassert_equal(heard.data[5], 0);
	device_step(900 * MS);
	zassert_false(tool_hears(900 * MS, &dronecan_hardpoint_status_type, &heard));
	report(950 * MS, true);
	device_step(950 * MS);
	zassert_true(tool_hears(950 * MS, &dronecan_hardpoint_status_type, &heard));
	zassert_equal(heard.data[5], 1);
	device_step(1949 * MS);
	zassert_false(tool_hears(1949 * MS, &dronecan_hardpoint_status_type, &heard));
	device_step(1950 * MS);
	zassert_true(tool_hears(1950 * MS, &dronecan_hardpoint_status_type, &heard));
}

ZTEST(dronecan_lights, test_temperature_is_in_kelvin)
{
	/* device 254, 300 K = 0x5CB0 as float16, overheating. */
	static const uint8_t expected[] = {0xFE, 0x00, 0xB0, 0x5C, 0x01};

	device_step(0);
	zassert_false(tool_hears(0, &dronecan_device_temperature_type, &heard), "not known yet");
	report(SECOND, false);
	device_step(SECOND);
	zassert_true(tool_hears(SECOND, &dronecan_device_temperature_type, &heard));
	zassert_equal(heard.size, sizeof(expected));
	zassert_mem_equal(heard.data, expected, sizeof(expected));
}
