/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The table of docs/security.md, written out once more: a letter for each right, in the order of
 * enum security_right (read, exist, light, gimbal, outputs, params, supervision, lock, key,
 * restart, update). y granted, x excluded, k no key, - never.
 */
#include "core/security.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

ZTEST_SUITE(core_security, NULL, NULL, NULL, NULL, NULL);

/* Sums of LGT_SRC_EXCL. */
#define EXCLUDED_MAVLINK  1u
#define EXCLUDED_DRONECAN 2u
#define EXCLUDED_IMC      4u
#define EXCLUDED_SHELL    8u

static const struct security open = {0};
static const struct security key = {.has_key = true};

static char letter_of(enum security_verdict verdict)
{
	switch (verdict) {
	case SECURITY_GRANTED:
		return 'y';
	case SECURITY_EXCLUDED:
		return 'x';
	case SECURITY_NO_KEY:
		return 'k';
	case SECURITY_FORBIDDEN:
		return '-';
	}
	return '?';
}

static void check(const struct security *state, enum security_way way, const char *rights)
{
	char found[SECURITY_RIGHTS + 1] = {0};

	for (uint32_t right = 0; right < SECURITY_RIGHTS; right++) {
		found[right] = letter_of(security_check(state, way, (enum security_right)right));
	}
	zassert_equal(strcmp(found, rights), 0, "way %d: %s, not %s", way, found, rights);
}

ZTEST(core_security, test_without_a_key_everybody_may)
{
	check(&open, SECURITY_WAY_MAVLINK, "yyyyyyyyyyy");
	check(&open, SECURITY_WAY_MAVLINK_SIGNED, "yyyyyyyyyyy");
	check(&open, SECURITY_WAY_DRONECAN, "yyyyyyyy-yy");
	check(&open, SECURITY_WAY_IMC, "yyyyyyyy-yy");
	check(&open, SECURITY_WAY_SHELL, "yyyyyyyyyyy");
	check(&open, SECURITY_WAY_BUTTON, "-yy--------");
}

ZTEST(core_security, test_with_a_key_only_who_has_it)
{
	check(&key, SECURITY_WAY_MAVLINK, "kkkkkkkkkkk");
	check(&key, SECURITY_WAY_MAVLINK_SIGNED, "yyyyyyyyyyy");
	check(&key, SECURITY_WAY_DRONECAN, "ykkkkkkk-kk");
	check(&key, SECURITY_WAY_IMC, "ykkkkkkk-kk");
	check(&key, SECURITY_WAY_SHELL, "yyyyyyyyyyy");
	check(&key, SECURITY_WAY_BUTTON, "-yy--------");
}

ZTEST(core_security, test_grants_beside_a_key)
{
	const struct security light_can = {.has_key = true, .dronecan = SECURITY_GRANT_LIGHT};
	const struct security light_imc = {.has_key = true, .imc = SECURITY_GRANT_LIGHT};
	const struct security all = {
		.has_key = true,
		.dronecan = SECURITY_GRANT_ALL,
		.imc = SECURITY_GRANT_ALL,
	};

	check(&light_can, SECURITY_WAY_DRONECAN, "yyyyykkk-kk");
	check(&light_can, SECURITY_WAY_IMC, "ykkkkkkk-kk");
	check(&light_imc, SECURITY_WAY_IMC, "yyyyykkk-kk");
	check(&light_imc, SECURITY_WAY_DRONECAN, "ykkkkkkk-kk");
	check(&all, SECURITY_WAY_DRONECAN, "yyyyyyyk-yy");
	check(&all, SECURITY_WAY_IMC, "yyyyyyyk-yy");
	check(&all, SECURITY_WAY_MAVLINK, "kkkkkkkkkkk");
}

ZTEST(core_security, test_an_excluded_source_may_look)
{
	const struct security mavlink = {.excluded = EXCLUDED_MAVLINK};
	const struct security buses = {.excluded = EXCLUDED_DRONECAN | EXCLUDED_IMC};
	const struct security shell = {.excluded = EXCLUDED_SHELL};

	check(&mavlink, SECURITY_WAY_MAVLINK, "yxxxxxxxxxx");
	check(&mavlink, SECURITY_WAY_MAVLINK_SIGNED, "yxxxxxxxxxx");
	check(&mavlink, SECURITY_WAY_DRONECAN, "yyyyyyyy-yy");
	check(&buses, SECURITY_WAY_DRONECAN, "yxxxxxxx-xx");
	check(&buses, SECURITY_WAY_IMC, "yxxxxxxx-xx");
	check(&buses, SECURITY_WAY_MAVLINK, "yyyyyyyyyyy");
	check(&shell, SECURITY_WAY_SHELL, "yxxxxxxyyyx");
	check(&shell, SECURITY_WAY_BUTTON, "-xx--------");
}

ZTEST(core_security, test_a_key_opens_nothing_to_the_excluded)
{
	const struct security both = {
		.has_key = true,
		.excluded = EXCLUDED_MAVLINK | EXCLUDED_DRONECAN | EXCLUDED_IMC | EXCLUDED_SHELL,
		.dronecan = SECURITY_GRANT_ALL,
		.imc = SECURITY_GRANT_ALL,
	};

	check(&both, SECURITY_WAY_MAVLINK, "kxxxxxxxxxx");
	check(&both, SECURITY_WAY_MAVLINK_SIGNED, "yxxxxxxxxxx");
	check(&both, SECURITY_WAY_DRONECAN, "yxxxxxxx-xx");
	check(&both, SECURITY_WAY_IMC, "yxxxxxxx-xx");
	check(&both, SECURITY_WAY_SHELL, "yxxxxxxyyyx");
	check(&both, SECURITY_WAY_BUTTON, "-xx--------");
}

ZTEST(core_security, test_whom_a_way_counts_as)
{
	zassert_equal(security_source(SECURITY_WAY_MAVLINK), ARBITER_SOURCE_MAVLINK);
	zassert_equal(security_source(SECURITY_WAY_MAVLINK_SIGNED), ARBITER_SOURCE_MAVLINK);
	zassert_equal(security_source(SECURITY_WAY_DRONECAN), ARBITER_SOURCE_DRONECAN);
	zassert_equal(security_source(SECURITY_WAY_IMC), ARBITER_SOURCE_IMC);
	zassert_equal(security_source(SECURITY_WAY_SHELL), ARBITER_SOURCE_SHELL);
	zassert_equal(security_source(SECURITY_WAY_BUTTON), ARBITER_SOURCE_SHELL);
}

ZTEST(core_security, test_what_is_no_way_is_a_bug)
{
	expect_assert();
	(void)security_check(&open, SECURITY_WAYS, SECURITY_READ);
}

ZTEST(core_security, test_what_is_no_right_is_a_bug)
{
	expect_assert();
	(void)security_check(&open, SECURITY_WAY_SHELL, SECURITY_RIGHTS);
}
