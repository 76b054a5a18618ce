/* SPDX-License-Identifier: Apache-2.0 */
/* Decimal numbers as people write them, against the same written by hand as integers. */
#include <string.h>

#include <zephyr/ztest.h>

#include "core/decimal.h"

#define UNTOUCHED INT64_C(-77)

ZTEST_SUITE(core_decimal, NULL, NULL, NULL, NULL, NULL);

static void expect_parsed(const char *text, unsigned int decimals, int64_t expected)
{
	int64_t value = UNTOUCHED;

	zassert_true(decimal_parse_exact(text, decimals, &value), "%s", text);
	zassert_equal(value, expected, "%s is not %lld", text, (long long)value);
}

static void expect_refused(const char *text, unsigned int decimals)
{
	int64_t value = UNTOUCHED;

	zassert_false(decimal_parse_exact(text, decimals, &value), "%s", text);
	zassert_equal(value, UNTOUCHED);
}

ZTEST(core_decimal, test_numbers)
{
	expect_parsed("0", 0, 0);
	expect_parsed("40", 4, 400000);
	expect_parsed("0.5", 6, 500000);
	expect_parsed("-0.5", 6, -500000);
	expect_parsed("12.3456", 4, 123456);
	expect_parsed("7.", 2, 700);
	expect_parsed("007", 0, 7);
}

ZTEST(core_decimal, test_digits_beyond_the_decimals_must_be_zeros)
{
	expect_parsed("0.100000", 1, 1);
	expect_refused("0.11", 1);
}

static void expect_rounded(const char *text, unsigned int decimals, int64_t expected)
{
	int64_t value = UNTOUCHED;

	zassert_equal(decimal_parse(text, strlen(text), decimals, &value), DECIMAL_ROUNDED);
	zassert_equal(value, expected, "%s is not %lld", text, (long long)value);
}

ZTEST(core_decimal, test_digits_beyond_the_decimals_round_to_the_nearest)
{
	expect_rounded("0.14", 1, 1);
	expect_rounded("0.15", 1, 2);
	expect_rounded("0.1499", 1, 1);
	expect_rounded("-0.15", 1, -2);
	expect_rounded("-0.04", 1, 0);
	expect_rounded("9.99", 1, 100);
	expect_rounded("2.5", 0, 3);
	expect_rounded("922337203685477580.64", 1, INT64_MAX - 1);
	expect_refused("922337203685477580.75", 1); /* would be INT64_MAX + 1 */
}

ZTEST(core_decimal, test_a_length_ends_the_text)
{
	int64_t value = UNTOUCHED;

	zassert_equal(decimal_parse("12345", 2, 0, &value), DECIMAL_EXACT);
	zassert_equal(value, 12);
	zassert_equal(decimal_parse("1.25", 3, 1, &value), DECIMAL_EXACT);
	zassert_equal(value, 12);
	value = UNTOUCHED;
	zassert_equal(decimal_parse("-1", 1, 0, &value), DECIMAL_NO_NUMBER);
	zassert_equal(decimal_parse("1", 0, 0, &value), DECIMAL_NO_NUMBER);
	zassert_equal(value, UNTOUCHED);
}

ZTEST(core_decimal, test_what_is_no_number)
{
	static const char *const texts[] = {"",   "-",     ".5",  "1e3", "1 ",
	                                    " 1", "1.2.3", "nan", "+1",  "1,5"};

	for (size_t i = 0; i < ARRAY_SIZE(texts); i++) {
		expect_refused(texts[i], 3);
	}
}

ZTEST(core_decimal, test_too_large)
{
	/* INT64_MAX = 9223372036854775807 */
	expect_parsed("922337203685477580.7", 1, INT64_MAX);
	expect_parsed("9223372036854775807", 0, INT64_MAX);
	expect_refused("9223372036854775808", 0);
	expect_refused("99999999999999999999", 0);
	expect_refused("9223372036854775", 9);
}

static void expect_text(int64_t value, unsigned int decimals, const char *expected)
{
	char text[DECIMAL_TEXT_MAX];

	zassert_equal(decimal_print(text, value, decimals), strlen(expected));
	zassert_equal(strcmp(text, expected), 0, "%s", text);
}

ZTEST(core_decimal, test_texts)
{
	expect_text(0, 0, "0");
	expect_text(0, 6, "0");
	expect_text(400000, 4, "40");
	expect_text(500000, 6, "0.5");
	expect_text(-25082, 3, "-25.082");
	expect_text(1, 9, "0.000000001");
	expect_text(INT64_MAX, 0, "9223372036854775807");
	expect_text(INT64_MIN, 9, "-9223372036.854775808");
}
