/* SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>

#include <zephyr/ztest.h>

#include "kernel/port.h"
#include "ztest_native.h"

enum phase {
	PHASE_SETUP,
	PHASE_TEST,
	PHASE_AFTER,
	PHASE_TEARDOWN
};
enum result {
	RESULT_PASS,
	RESULT_FAIL,
	RESULT_SKIP,
	RESULT_COUNT
};

static K_THREAD_STACK_DEFINE(test_stack, CONFIG_ZTEST_STACK_SIZE);
static struct k_thread test_thread;

static enum phase phase;
static const struct ztest_suite_node *suite;
static const struct ztest_unit_test *unit;
static void *fixture;
static enum result result;
static unsigned int totals[RESULT_COUNT];

static void print_replay(void)
{
	printk("    run again: --test %s%s%s%s\n", suite != NULL ? suite->name : "",
	       unit != NULL ? "::" : "", unit != NULL ? unit->name : "", ztest_native_replay());
}

/* Outside a test there is no thread that could end alone. */
static void end_test(enum result how)
{
	if (phase != PHASE_TEST && phase != PHASE_AFTER) {
		printk("FAIL: suite %s ended outside its tests\n", suite->name);
		print_replay();
		port_exit(1);
	}
	if (result != RESULT_FAIL) {
		result = how;
	}
	if (phase == PHASE_AFTER) {
		return;
	}
	if (k_current_get() != &test_thread) {
		k_thread_abort(&test_thread);
	}
	k_thread_abort(k_current_get());
}

void ztest_test_fail(void)
{
	end_test(RESULT_FAIL);
}

void ztest_test_pass(void)
{
	end_test(RESULT_PASS);
}

void ztest_test_skip(void)
{
	end_test(RESULT_SKIP);
}

void ztest_simple_1cpu_before(void *data)
{
	ARG_UNUSED(data);
}

void ztest_simple_1cpu_after(void *data)
{
	ARG_UNUSED(data);
}

static void print_failure(const char *what, const char *file, int line, const char *func,
                          va_list message)
{
	const char *const format = va_arg(message, const char *);

	printk("    %s:%d: %s: %s\n", file, line, func, what);
	if (format != NULL && format[0] != '\0') {
		printk("    ");
		vprintk(format, message);
		printk("\n");
	}
}

bool z_ztest_check(bool cond, const char *what, const char *file, int line, const char *func, ...)
{
	if (!cond) {
		va_list message;

		va_start(message, func);
		print_failure(what, file, line, func, message);
		va_end(message);
	}
	return cond;
}

bool z_ztest_expect(bool cond, const char *what, const char *file, int line, const char *func, ...)
{
	if (!cond) {
		va_list message;

		va_start(message, func);
		print_failure(what, file, line, func, message);
		va_end(message);
		result = RESULT_FAIL;
	}
	return cond;
}

/* A fatal error that the test did not handle leaves the kernel in no state to go on. */
void k_fatal_halt(unsigned int reason)
{
	printk(" FAIL - %s: fatal error %u\n", unit != NULL ? unit->name : "setup", reason);
	print_replay();
	port_exit(1);
}

static void run_test(void *p1, void *p2, void *p3)
{
	ARG_UNUSED(p1);
	ARG_UNUSED(p2);
	ARG_UNUSED(p3);

	if (suite->before != NULL) {
		suite->before(fixture);
	}
	unit->run(fixture);
}

static void run_unit(void)
{
	static const char *const names[] = {"PASS", "FAIL", "SKIP"};
	const int64_t start_ms = k_uptime_get();

	printk("START - %s\n", unit->name);
	phase = PHASE_TEST;
	result = RESULT_PASS;
	(void)k_thread_create(&test_thread, test_stack, K_THREAD_STACK_SIZEOF(test_stack), run_test,
	                      NULL, NULL, NULL, CONFIG_ZTEST_THREAD_PRIORITY, 0, K_FOREVER);
	(void)k_thread_name_set(&test_thread, unit->name);
	k_thread_start(&test_thread);
	(void)k_thread_join(&test_thread, K_FOREVER);
	phase = PHASE_AFTER;
	if (suite->after != NULL) {
		suite->after(fixture);
	}

	const int64_t took_ms = k_uptime_get() - start_ms;

	printk(" %s - %s in %lld.%03lld seconds\n", names[result], unit->name,
	       (long long)(took_ms / 1000), (long long)(took_ms % 1000));
	if (result == RESULT_FAIL) {
		print_replay();
	}
	totals[result]++;
}

/* The next selected test of the suite after the given name; "" : the first. */
static const struct ztest_unit_test *next_unit(const char *name)
{
	const struct ztest_unit_test *best = NULL;

	TYPE_SECTION_FOREACH(const struct ztest_unit_test, ztest_unit_test, at)
	{
		if (strcmp(at->suite_name, suite->name) == 0 && strcmp(at->name, name) > 0 &&
		    (best == NULL || strcmp(at->name, best->name) < 0) &&
		    ztest_native_selected(suite->name, at->name)) {
			best = at;
		}
	}
	return best;
}

static const struct ztest_suite_node *next_suite(const char *name)
{
	const struct ztest_suite_node *best = NULL;

	TYPE_SECTION_FOREACH(const struct ztest_suite_node, ztest_suite_node, at)
	{
		if (strcmp(at->name, name) > 0 &&
		    (best == NULL || strcmp(at->name, best->name) < 0)) {
			best = at;
		}
	}
	return best;
}

static void run_suite(void)
{
	const unsigned int failed_before = totals[RESULT_FAIL];

	unit = NULL;
	if (next_unit("") == NULL || (suite->predicate != NULL && !suite->predicate(NULL))) {
		return;
	}
	printk("Running TESTSUITE %s\n", suite->name);
	phase = PHASE_SETUP;
	fixture = suite->setup != NULL ? suite->setup() : NULL;
	for (unit = next_unit(""); unit != NULL; unit = next_unit(unit->name)) {
		run_unit();
	}
	phase = PHASE_TEARDOWN;
	if (suite->teardown != NULL) {
		suite->teardown(fixture);
	}
	printk("TESTSUITE %s %s\n\n", suite->name,
	       totals[RESULT_FAIL] == failed_before ? "succeeded" : "failed");
}

int main(void)
{
	unsigned int count;

	for (suite = next_suite(""); suite != NULL; suite = next_suite(suite->name)) {
		run_suite();
	}
	count = totals[RESULT_PASS] + totals[RESULT_FAIL] + totals[RESULT_SKIP];
	printk("%u tests: %u passed, %u failed, %u skipped\n", count, totals[RESULT_PASS],
	       totals[RESULT_FAIL], totals[RESULT_SKIP]);
	if (count == 0) {
		printk("no test has that name\n");
	}
	printk("PROJECT EXECUTION %s\n",
	       totals[RESULT_FAIL] == 0 && count > 0 ? "SUCCESSFUL" : "FAILED");
	port_exit(totals[RESULT_FAIL] == 0 && count > 0 ? 0 : 1);
}
