/* SPDX-License-Identifier: Apache-2.0 */
/* Bit timing: the arithmetic of CiA 301 and of ISO 11898-1, checked backwards. */
#include <zephyr/drivers/can.h>
#include <zephyr/ztest.h>

#define CLOCK_HZ 80000000u

static const struct device *const can = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));

ZTEST_SUITE(can_timing, NULL, NULL, NULL, NULL, NULL);

static void check(const struct can_timing *timing, const struct can_timing *min,
                  const struct can_timing *max, uint32_t bitrate, uint32_t sample_permille)
{
	const uint32_t quanta = 1u + timing->prop_seg + timing->phase_seg1 + timing->phase_seg2;

	zassert_equal(timing->prescaler * quanta * bitrate, CLOCK_HZ, "%u bit/s", bitrate);
	zassert_within((int)((quanta - timing->phase_seg2) * 1000u / quanta), (int)sample_permille,
	               50);
	zassert_between_inclusive(timing->prop_seg, min->prop_seg, max->prop_seg);
	zassert_between_inclusive(timing->phase_seg1, min->phase_seg1, max->phase_seg1);
	zassert_between_inclusive(timing->phase_seg2, min->phase_seg2, max->phase_seg2);
	zassert_between_inclusive(timing->prescaler, min->prescaler, max->prescaler);
}

ZTEST(can_timing, test_usual_rates)
{
	/* CiA 301, 87.5 %; Linux has 80 % above 500 and 75 % above 800 kbit/s */
	static const struct {
		uint32_t bitrate;
		uint16_t sample_permille;
	} cases[] = {{20000, 875},  {50000, 875},  {125000, 875}, {250000, 875},
	             {500000, 875}, {800000, 800}, {1000000, 750}};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		struct can_timing timing = {0};

		zassert_true(can_calc_timing(can, &timing, cases[i].bitrate, 0) >= 0);
		check(&timing, can_get_timing_min(can), can_get_timing_max(can), cases[i].bitrate,
		      cases[i].sample_permille);
		zassert_ok(can_set_bitrate(can, cases[i].bitrate));
	}
}

ZTEST(can_timing, test_data_rates)
{
	static const uint32_t bitrates[] = {500000, 1000000, 2000000, 4000000, 5000000, 8000000};

	for (size_t i = 0; i < ARRAY_SIZE(bitrates); i++) {
		struct can_timing timing = {0};

		zassert_true(can_calc_timing_data(can, &timing, bitrates[i], 750) >= 0);
		check(&timing, can_get_timing_data_min(can), can_get_timing_data_max(can),
		      bitrates[i], 750);
		zassert_ok(can_set_bitrate_data(can, bitrates[i]));
	}
}

ZTEST(can_timing, test_out_of_range)
{
	struct can_timing timing = {0};

	zassert_equal(can_calc_timing(can, &timing, 0, 0), -EINVAL);
	zassert_equal(can_calc_timing(can, &timing, 1000001, 0), -EINVAL);
	zassert_equal(can_calc_timing(can, &timing, 125000, 1000), -EINVAL);
	zassert_equal(can_calc_timing_data(can, &timing, 8000001, 0), -EINVAL);
	zassert_equal(can_set_bitrate(can, can_get_bitrate_max(can) + 1), -ENOTSUP);
	zassert_equal(can_set_bitrate(can, can_get_bitrate_min(can) - 1), -ENOTSUP);
	zassert_equal(can_set_bitrate_data(can, can_get_bitrate_max(can) + 1), -ENOTSUP);
	zassert_equal(can_set_bitrate(can, 1000001), -EINVAL);
	/* 80 MHz is no multiple of 7 kHz */
	zassert_equal(can_set_bitrate(can, 700000), -ENOTSUP);
}

ZTEST(can_timing, test_limits_can_be_set_and_nothing_beyond)
{
	struct can_timing timing = *can_get_timing_max(can);

	zassert_ok(can_set_timing(can, can_get_timing_min(can)));
	zassert_ok(can_set_timing(can, &timing));
	timing.phase_seg1++;
	zassert_equal(can_set_timing(can, &timing), -ENOTSUP);
	zassert_ok(can_set_timing_data(can, can_get_timing_data_min(can)));
	zassert_ok(can_set_timing_data(can, can_get_timing_data_max(can)));
	zassert_ok(can_set_bitrate(can, 1000000));
}
