/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Unit tests, with the names and rules of Zephyr's ztest.
 *
 * Each test runs in a thread of its own, with CONFIG_ZTEST_THREAD_PRIORITY; suites and their tests
 * run in the order of their names. setup() once before a suite's tests; before(), in the test's
 * thread, and after() around each; teardown() once. `--test suite`, `--test suite::name` on the
 * command line select. A failed test says where, and how to run it again; then the exit status
 * is 1.
 */
#ifndef ZEPHYR_ZTEST_H_
#define ZEPHYR_ZTEST_H_

#include <stdbool.h>
#include <string.h>

#include <zephyr/kernel.h>

typedef bool (*ztest_suite_predicate_t)(const void *global_state);
typedef void *(*ztest_suite_setup_t)(void);
typedef void (*ztest_suite_before_t)(void *fixture);
typedef void (*ztest_suite_after_t)(void *fixture);
typedef void (*ztest_suite_teardown_t)(void *fixture);

struct ztest_suite_node {
	const char *name;
	ztest_suite_predicate_t predicate; /* false: the suite does not run */
	ztest_suite_setup_t setup;
	ztest_suite_before_t before;
	ztest_suite_after_t after;
	ztest_suite_teardown_t teardown;
};

struct ztest_unit_test {
	const char *suite_name;
	const char *name;
	void (*run)(void *fixture);
};

/* Any of the functions may be NULL. The fixture that the others get is what setup() returned. */
#define ZTEST_SUITE(suite, predicate_fn, setup_fn, before_fn, after_fn, teardown_fn)               \
	const STRUCT_SECTION_ITERABLE(ztest_suite_node, z_ztest_suite_##suite) = {                 \
		.name = #suite,                                                                    \
		.predicate = (predicate_fn),                                                       \
		.setup = (setup_fn),                                                               \
		.before = (before_fn),                                                             \
		.after = (after_fn),                                                               \
		.teardown = (teardown_fn),                                                         \
	}

#define NATIVE_ZTEST(suite, fn, call)                                                              \
	static void z_ztest_run_##suite##_##fn(void *fixture)                                      \
	{                                                                                          \
		ARG_UNUSED(fixture);                                                               \
		call;                                                                              \
	}                                                                                          \
	static const STRUCT_SECTION_ITERABLE(ztest_unit_test, z_ztest_unit_##suite##_##fn) = {     \
		.suite_name = #suite,                                                              \
		.name = #fn,                                                                       \
		.run = z_ztest_run_##suite##_##fn,                                                 \
	}

#define ZTEST(suite, fn)                                                                           \
	static void z_ztest_##suite##_##fn(void);                                                  \
	NATIVE_ZTEST(suite, fn, z_ztest_##suite##_##fn());                                         \
	static void z_ztest_##suite##_##fn(void)

/* With `struct suite_fixture *fixture` in scope. */
#define ZTEST_F(suite, fn)                                                                         \
	static void z_ztest_##suite##_##fn(struct suite##_fixture *fixture);                       \
	NATIVE_ZTEST(suite, fn, z_ztest_##suite##_##fn((struct suite##_fixture *)fixture));        \
	static void z_ztest_##suite##_##fn(struct suite##_fixture *fixture)

/* There is no user mode. */
#define ZTEST_USER(suite, fn)   ZTEST(suite, fn)
#define ZTEST_USER_F(suite, fn) ZTEST_F(suite, fn)
#define ZTEST_BMEM
#define ZTEST_DMEM

/* End the current test; from another thread, that thread ends as well. */
void ztest_test_fail(void);
void ztest_test_pass(void);
void ztest_test_skip(void);

/* For suites of machines with several CPUs. */
void ztest_simple_1cpu_before(void *data);
void ztest_simple_1cpu_after(void *data);

#define TC_PRINT(fmt, ...) printk(fmt, ##__VA_ARGS__)
#define TC_ERROR(fmt, ...) printk("FAIL - %s@%d. " fmt, __func__, __LINE__, ##__VA_ARGS__)
#define TC_PASS            0
#define TC_FAIL            1
#define TC_SKIP            2

/*
 * Says what failed; the arguments after func are an optional printf format with its values, then
 * NULL. Returns cond. The second marks the test as failed.
 */
bool z_ztest_check(bool cond, const char *what, const char *file, int line, const char *func, ...);
bool z_ztest_expect(bool cond, const char *what, const char *file, int line, const char *func, ...);

#define NATIVE_ZTEST_CHECK(check, cond, what, ...)                                                 \
	check(cond, what, __FILE__, __LINE__, __func__, ##__VA_ARGS__, NULL)

#define zassert(cond, what, ...)                                                                   \
	do {                                                                                       \
		if (!NATIVE_ZTEST_CHECK(z_ztest_check, cond, what, ##__VA_ARGS__)) {               \
			ztest_test_fail();                                                         \
		}                                                                                  \
	} while (0)
#define zassume(cond, what, ...)                                                                   \
	do {                                                                                       \
		if (!NATIVE_ZTEST_CHECK(z_ztest_check, cond, what, ##__VA_ARGS__)) {               \
			ztest_test_skip();                                                         \
		}                                                                                  \
	} while (0)
#define zexpect(cond, what, ...)                                                                   \
	((void)NATIVE_ZTEST_CHECK(z_ztest_expect, cond, what, ##__VA_ARGS__))

#define zassert_unreachable(...)     zassert(false, "reached", ##__VA_ARGS__)
#define zassert_true(cond, ...)      zassert((cond) != 0, #cond " is false", ##__VA_ARGS__)
#define zassert_false(cond, ...)     zassert((cond) == 0, #cond " is true", ##__VA_ARGS__)
#define zassert_ok(cond, ...)        zassert((cond) == 0, #cond " is not 0", ##__VA_ARGS__)
#define zassert_not_ok(cond, ...)    zassert((cond) != 0, #cond " is 0", ##__VA_ARGS__)
#define zassert_is_null(ptr, ...)    zassert((ptr) == NULL, #ptr " is not NULL", ##__VA_ARGS__)
#define zassert_not_null(ptr, ...)   zassert((ptr) != NULL, #ptr " is NULL", ##__VA_ARGS__)
#define zassert_equal(a, b, ...)     zassert((a) == (b), #a " is not " #b, ##__VA_ARGS__)
#define zassert_not_equal(a, b, ...) zassert((a) != (b), #a " is " #b, ##__VA_ARGS__)
#define zassert_equal_ptr(a, b, ...)                                                               \
	zassert((const void *)(a) == (const void *)(b), #a " is not " #b, ##__VA_ARGS__)
#define zassert_within(a, b, d, ...)                                                               \
	zassert((a) >= ((b) - (d)) && (a) <= ((b) + (d)), #a " is not within " #b " +/- " #d,      \
	        ##__VA_ARGS__)
#define zassert_between_inclusive(a, l, u, ...)                                                    \
	zassert((a) >= (l) && (a) <= (u), #a " is not in " #l " to " #u, ##__VA_ARGS__)
#define zassert_mem_equal(buf, exp, size, ...)                                                     \
	zassert(memcmp(buf, exp, size) == 0, #buf " differs from " #exp, ##__VA_ARGS__)

#define zassume_unreachable(...)     zassume(false, "reached", ##__VA_ARGS__)
#define zassume_true(cond, ...)      zassume((cond) != 0, #cond " is false", ##__VA_ARGS__)
#define zassume_false(cond, ...)     zassume((cond) == 0, #cond " is true", ##__VA_ARGS__)
#define zassume_ok(cond, ...)        zassume((cond) == 0, #cond " is not 0", ##__VA_ARGS__)
#define zassume_not_ok(cond, ...)    zassume((cond) != 0, #cond " is 0", ##__VA_ARGS__)
#define zassume_is_null(ptr, ...)    zassume((ptr) == NULL, #ptr " is not NULL", ##__VA_ARGS__)
#define zassume_not_null(ptr, ...)   zassume((ptr) != NULL, #ptr " is NULL", ##__VA_ARGS__)
#define zassume_equal(a, b, ...)     zassume((a) == (b), #a " is not " #b, ##__VA_ARGS__)
#define zassume_not_equal(a, b, ...) zassume((a) != (b), #a " is " #b, ##__VA_ARGS__)
#define zassume_equal_ptr(a, b, ...)                                                               \
	zassume((const void *)(a) == (const void *)(b), #a " is not " #b, ##__VA_ARGS__)
#define zassume_within(a, b, d, ...)                                                               \
	zassume((a) >= ((b) - (d)) && (a) <= ((b) + (d)), #a " is not within " #b " +/- " #d,      \
	        ##__VA_ARGS__)
#define zassume_between_inclusive(a, l, u, ...)                                                    \
	zassume((a) >= (l) && (a) <= (u), #a " is not in " #l " to " #u, ##__VA_ARGS__)
#define zassume_mem_equal(buf, exp, size, ...)                                                     \
	zassume(memcmp(buf, exp, size) == 0, #buf " differs from " #exp, ##__VA_ARGS__)

#define zexpect_unreachable(...)     zexpect(false, "reached", ##__VA_ARGS__)
#define zexpect_true(cond, ...)      zexpect((cond) != 0, #cond " is false", ##__VA_ARGS__)
#define zexpect_false(cond, ...)     zexpect((cond) == 0, #cond " is true", ##__VA_ARGS__)
#define zexpect_ok(cond, ...)        zexpect((cond) == 0, #cond " is not 0", ##__VA_ARGS__)
#define zexpect_not_ok(cond, ...)    zexpect((cond) != 0, #cond " is 0", ##__VA_ARGS__)
#define zexpect_is_null(ptr, ...)    zexpect((ptr) == NULL, #ptr " is not NULL", ##__VA_ARGS__)
#define zexpect_not_null(ptr, ...)   zexpect((ptr) != NULL, #ptr " is NULL", ##__VA_ARGS__)
#define zexpect_equal(a, b, ...)     zexpect((a) == (b), #a " is not " #b, ##__VA_ARGS__)
#define zexpect_not_equal(a, b, ...) zexpect((a) != (b), #a " is " #b, ##__VA_ARGS__)
#define zexpect_equal_ptr(a, b, ...)                                                               \
	zexpect((const void *)(a) == (const void *)(b), #a " is not " #b, ##__VA_ARGS__)
#define zexpect_within(a, b, d, ...)                                                               \
	zexpect((a) >= ((b) - (d)) && (a) <= ((b) + (d)), #a " is not within " #b " +/- " #d,      \
	        ##__VA_ARGS__)
#define zexpect_between_inclusive(a, l, u, ...)                                                    \
	zexpect((a) >= (l) && (a) <= (u), #a " is not in " #l " to " #u, ##__VA_ARGS__)
#define zexpect_mem_equal(buf, exp, size, ...)                                                     \
	zexpect(memcmp(buf, exp, size) == 0, #buf " differs from " #exp, ##__VA_ARGS__)
#define zexpect_str_equal(s1, s2, ...)                                                             \
	zexpect(strcmp(s1, s2) == 0, #s1 " differs from " #s2, ##__VA_ARGS__)

#endif
