/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Expected temperatures were computed apart from the driver, with Python's math.log from
 * T = 1 / (1/298.15 + ln(R/r25) / beta), R = code * pullup / (full - code).
 */
#include <stdlib.h>

#include <zephyr/devicetree.h>
#include <zephyr/drivers/adc.h>
#include <zephyr/ztest.h>

#include <pharos/drivers/thermistor.h>

#include "host/clock.h"
#include "models/board.h"
#include "thermistor/ntc_math.h"

static const struct device *const thermistor = DEVICE_DT_GET(DT_ALIAS(thermistor0));

static void set_lamp(double temp_c)
{
	thermal_mass_set_temp(&board.housing, (int64_t)clock_board_us(), temp_c);
}

static void before(void *fixture)
{
	board.faults[BOARD_CHIP_ADC].kind = BOARD_FAULT_NONE;
	ntc_input_set_fault(&board.thermistor, NTC_FAULT_NONE);
	set_lamp(25.0);
}

struct point {
	uint32_t code;
	int32_t temp_mdegc;
};

ZTEST(thermistor, test_integers_follow_the_formula_to_10_mk)
{
	static const struct ntc_divider divider = {10000, 10000, 3435};
	/* of 16 conversions of 12 bits: full = 65520 */
	static const struct point points[] = {
		{656, 222724},   {1000, 193938},  {3418, 125281},  {10000, 77114},
		{20000, 47919},  {32760, 25000},  {40000, 13806},  {50000, -2484},
		{60000, -26152}, {62975, -39947}, {64864, -59994},
	};

	for (size_t i = 0; i < ARRAY_SIZE(points); i++) {
		zassert_within(ntc_temp_mdegc(&divider, points[i].code, 65520),
		               points[i].temp_mdegc, 10, "code %u", points[i].code);
	}
}

ZTEST(thermistor, test_another_thermistor_and_pullup)
{
	static const struct ntc_divider divider = {4700, 100000, 3950};
	static const struct point points[] = {
		{50, 408173}, {400, 222615}, {2000, 116229}, {3900, 26399}, {3975, 15360},
	};

	for (size_t i = 0; i < ARRAY_SIZE(points); i++) {
		zassert_within(ntc_temp_mdegc(&divider, points[i].code, 4095), points[i].temp_mdegc,
		               10, "code %u", points[i].code);
	}
}

ZTEST(thermistor, test_every_code_gives_a_temperature_and_they_fall)
{
	static const struct ntc_divider divider = {10000, 10000, 3435};
	int32_t last = INT32_MAX;

	for (uint32_t code = 1; code < 65520; code++) {
		const int32_t temp_mdegc = ntc_temp_mdegc(&divider, code, 65520);

		zassert_true(temp_mdegc <= last, "code %u", code);
		last = temp_mdegc;
	}
	zassert_true(last < -100000);
}

ZTEST(thermistor, test_half_a_degree_over_the_whole_range)
{
	for (int celsius = -40; celsius <= 125; celsius++) {
		struct thermistor_sample sample;

		set_lamp(celsius);
		zassert_ok(thermistor_sample(thermistor, &sample));
		zassert_equal(sample.status, THERMISTOR_OK);
		zassert_within(sample.temp_mdegc, celsius * 1000, 500);
		/* 16 conversions of 12 bits */
		zassert_equal(sample.raw_max, 65520);
		zassert_true(sample.raw < sample.raw_max);
	}
}

ZTEST(thermistor, test_open_and_short_are_told_from_temperatures)
{
	struct thermistor_sample sample;

	ntc_input_set_fault(&board.thermistor, NTC_FAULT_OPEN);
	zassert_ok(thermistor_sample(thermistor, &sample));
	zassert_equal(sample.status, THERMISTOR_OPEN);
	zassert_equal(sample.temp_mdegc, 0);
	ntc_input_set_fault(&board.thermistor, NTC_FAULT_SHORT);
	zassert_ok(thermistor_sample(thermistor, &sample));
	zassert_equal(sample.status, THERMISTOR_SHORT);
	zassert_equal(sample.temp_mdegc, 0);
	ntc_input_set_fault(&board.thermistor, NTC_FAULT_NONE);
	zassert_ok(thermistor_sample(thermistor, &sample));
	zassert_equal(sample.status, THERMISTOR_OK);
}

ZTEST(thermistor, test_raw_sum_is_never_still_unless_stuck)
{
	struct thermistor_sample sample;
	struct thermistor_sample next;
	int same = 0;
	int longest = 0;

	zassert_ok(thermistor_sample(thermistor, &sample));
	for (int i = 0; i < 1000; i++) {
		zassert_ok(thermistor_sample(thermistor, &next));
		same = next.raw == sample.raw ? same + 1 : 0;
		longest = MAX(longest, same);
		sample = next;
	}
	/* two sums are the same about one time in eight: 8^-10 for eleven in a row */
	zassert_true(longest < 10);
	ntc_input_set_fault(&board.thermistor, NTC_FAULT_STUCK);
	zassert_ok(thermistor_sample(thermistor, &sample));
	set_lamp(80.0);
	zassert_ok(thermistor_sample(thermistor, &next));
	zassert_equal(next.raw, sample.raw);
}

ZTEST(thermistor, test_converter_refuses_what_it_cannot)
{
	const struct device *const adc = DEVICE_DT_GET(DT_NODELABEL(adc0));
	uint16_t codes[2] = {7, 7};
	struct adc_sequence sequence = {
		.channels = BIT(0),
		.buffer = codes,
		.buffer_size = sizeof(codes[0]),
		.resolution = 12,
	};
	const struct adc_sequence_options twice = {.extra_samplings = 1};

	zassert_ok(adc_read(adc, &sequence));
	zassert_within((int)codes[0], 2047, 5);
	zassert_equal(codes[1], 7);
	sequence.options = &twice;
	zassert_equal(adc_read(adc, &sequence), -ENOMEM);
	sequence.buffer_size = sizeof(codes);
	zassert_ok(adc_read(adc, &sequence));
	zassert_not_equal(codes[1], 7);
	sequence.channels = BIT(1);
	zassert_equal(adc_read(adc, &sequence), -EINVAL, "never set up");
	sequence.channels = BIT(0);
	sequence.oversampling = 2;
	zassert_equal(adc_read(adc, &sequence), -ENOTSUP);
	sequence.oversampling = 0;
	sequence.resolution = 17;
	zassert_equal(adc_read(adc, &sequence), -EINVAL);
}

static void adc_fault(enum board_fault_kind kind, uint32_t delay_us)
{
	board.faults[BOARD_CHIP_ADC] = (struct board_fault){kind, delay_us};
}

ZTEST(thermistor, test_converter_that_fails_leaves_the_sample_alone)
{
	struct thermistor_sample sample = {.raw = 7};

	adc_fault(BOARD_FAULT_ERROR, 0);
	zassert_equal(thermistor_sample(thermistor, &sample), -EIO);
	zassert_equal(sample.raw, 7);
	adc_fault(BOARD_FAULT_NONE, 0);
	zassert_ok(thermistor_sample(thermistor, &sample));
}

ZTEST(thermistor, test_converter_may_take_its_time)
{
	struct thermistor_sample sample;
	const int64_t begin_ms = k_uptime_get();

	adc_fault(BOARD_FAULT_LATE, 99000);
	zassert_ok(thermistor_sample(thermistor, &sample));
	zassert_equal(k_uptime_get() - begin_ms, 99);
	zassert_within(sample.temp_mdegc, 25000, 500);
}

ZTEST_SUITE(thermistor, NULL, NULL, before, NULL, NULL);

/*
 * Runs after all others: that converter is not asked again. Zephyr's would keep its caller for
 * ever, and write into the buffer when it comes back.
 */
ZTEST(thermistor_silent, test_converter_that_does_not_answer_in_time_is_not_asked_again)
{
	struct thermistor_sample sample = {.raw = 7};
	int64_t begin_ms = k_uptime_get();

	adc_fault(BOARD_FAULT_LATE, 150000);
	zassert_equal(thermistor_sample(thermistor, &sample), -ETIMEDOUT);
	zassert_equal(k_uptime_get() - begin_ms, 100);
	zassert_equal(sample.raw, 7);
	adc_fault(BOARD_FAULT_NONE, 0);
	k_msleep(1000);
	begin_ms = k_uptime_get();
	zassert_equal(thermistor_sample(thermistor, &sample), -ETIMEDOUT);
	zassert_equal(k_uptime_get(), begin_ms);
}

ZTEST_SUITE(thermistor_silent, NULL, NULL, NULL, NULL, NULL);
