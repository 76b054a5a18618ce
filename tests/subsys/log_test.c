/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The log: line format, levels, ring. This file plays the only shell with log_backend, so that it
 * sees the lines.
 */
#include <stdio.h>
#include <string.h>

#include <zephyr/init.h>
#include <zephyr/irq_offload.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/logging/log_ctrl.h>
#include <zephyr/shell/shell.h>
#include <zephyr/ztest.h>

LOG_MODULE_REGISTER(probe, LOG_LEVEL_INF);

static void expect_str(const char *text, const char *expected)
{
	zassert_equal(strcmp(text, expected), 0, "\"%s\" is not \"%s\"", text, expected);
}

static char lines[8192];
static size_t used;

static int catch_init(const struct shell_transport *transport, const void *config,
                      shell_transport_handler_t evt_handler, void *context)
{
	return 0;
}

static int catch_write(const struct shell_transport *transport, const void *data, size_t length,
                       size_t *cnt)
{
	const size_t kept = MIN(length, sizeof(lines) - 1 - used);

	memcpy(&lines[used], data, kept);
	used += kept;
	lines[used] = '\0';
	*cnt = length;
	return 0;
}

static int catch_read(const struct shell_transport *transport, void *data, size_t length,
                      size_t *cnt)
{
	*cnt = 0;
	return 0;
}

static const struct shell_transport_api catch_api = {
	.init = catch_init,
	.write = catch_write,
	.read = catch_read,
};
static const struct shell_transport catch_transport = {.api = &catch_api};

SHELL_DEFINE(catching_shell, "", &catch_transport, 0, 0, SHELL_FLAG_CRLF_DEFAULT);

static int catch_start(void)
{
	const struct shell_backend_config_flags flags = {0};

	return shell_init(&catching_shell, NULL, flags, true, 0);
}

SYS_INIT(catch_start, POST_KERNEL, 0);

/* Lets the log's thread write. */
static const char *written(void)
{
	k_sleep(K_MSEC(1));
	return lines;
}

static void before(void *fixture)
{
	(void)written();
	used = 0;
	lines[0] = '\0';
}

ZTEST_SUITE(log, NULL, NULL, before, NULL, NULL);

/* What follows "[hh:mm:ss.mmm,uuu] ". */
static void expect_line(const char *text)
{
	const char *out = written();

	zassert_true(strlen(out) > 19, "\"%s\"", out);
	expect_str(&out[19], text);
}

ZTEST(log, test_line_format)
{
	LOG_INF("value %d of %s", 42, "x");
	zassert_equal(written()[0], '[');
	expect_line("<inf> probe: value 42 of x\n");
}

ZTEST(log, test_level_names)
{
	LOG_ERR("a");
	LOG_WRN("b");
	zassert_not_null(strstr(written(), "<err> probe: a\n"));
	zassert_not_null(strstr(written(), "<wrn> probe: b\n"));
}

ZTEST(log, test_level_of_the_module)
{
	/* registered with LOG_LEVEL_INF */
	LOG_DBG("not seen");
	LOG_HEXDUMP_DBG("abc", 3, "not seen");
	expect_str(written(), "");
}

ZTEST(log, test_timestamp)
{
	const int64_t ms = k_uptime_get();
	char expected[64];

	LOG_INF("now");
	/* hours, minutes and seconds of the uptime; a test does not run for an hour of virtual time
	 */
	(void)snprintf(expected, sizeof(expected), "[%02d:%02d:%02d.%03d,", (int)(ms / 3600000),
	               (int)(ms / 60000 % 60), (int)(ms / 1000 % 60), (int)(ms % 1000));
	zassert_mem_equal(written(), expected, 14);
	zassert_mem_equal(&lines[17], "] ", 2);
}

ZTEST(log, test_timestamp_past_an_hour)
{
	/* 1 h 1 min 1 s later */
	k_sleep(K_SECONDS(3661));
	LOG_INF("late");
	zassert_mem_equal(written(), "[01:01:", 7, "%s", lines);
}

ZTEST(log, test_text_is_rendered_at_the_call)
{
	char text[] = "then";

	LOG_INF("%s", text);
	memcpy(text, "now!", 4);
	expect_line("<inf> probe: then\n");
}

ZTEST(log, test_long_text_is_cut)
{
	char text[LOG_TEXT_MAX + 50];

	memset(text, 'a', sizeof(text) - 1);
	text[sizeof(text) - 1] = '\0';
	LOG_INF("%s", text);
	/* "[00:00:00.000,000] <inf> probe: " is 32 characters, then LOG_TEXT_MAX and the line end
	 */
	zassert_equal(strlen(written()), 32 + LOG_TEXT_MAX + 1);
	expect_str(&lines[32 + LOG_TEXT_MAX - 4], "a...\n");
}

ZTEST(log, test_hexdump)
{
	LOG_HEXDUMP_INF("0123456789abcdefgh", 18, "dump");
	(void)written();
	zassert_not_null(strstr(lines, "<inf> probe: dump\n"));
	zassert_not_null(strstr(lines, " 30 31 32 33 34 35 36 37  38 39 61 62 63 64 65 66 "
	                               "|0123456789abcdef\n"));
	zassert_not_null(strstr(lines, " 67 68 "));
	zassert_not_null(strstr(lines, "|gh\n"));
}

ZTEST(log, test_hexdump_of_too_much_says_so)
{
	static const uint8_t data[LOG_DATA_MAX + 5];

	LOG_HEXDUMP_INF(data, sizeof(data), "dump");
	zassert_not_null(strstr(written(), "(5 more bytes)\n"));
}

static void log_from_isr(const void *arg)
{
	LOG_WRN("from an interrupt");
}

ZTEST(log, test_from_an_interrupt)
{
	irq_offload(log_from_isr, NULL);
	expect_line("<wrn> probe: from an interrupt\n");
}

ZTEST(log, test_order_is_kept)
{
	const char *one;
	const char *two;

	LOG_INF("one");
	irq_offload(log_from_isr, NULL);
	one = strstr(written(), "one");
	two = strstr(lines, "interrupt");
	zassert_not_null(one);
	zassert_not_null(two);
	zassert_true(one < two);
}

ZTEST(log, test_full_ring_drops_and_counts)
{
	const uint32_t before_count = log_dropped_cnt();
	uint32_t dropped;
	char expected[64];
	int shown = 0;

	/* The log's thread, of the lowest priority, does not run in between. */
	for (int i = 0; i < 1000; i++) {
		LOG_INF("%d", i);
	}
	dropped = log_dropped_cnt() - before_count;
	zassert_true(dropped > 0);
	zassert_equal(log_buffered_cnt() + dropped, 1000);
	(void)written();
	for (const char *at = lines; (at = strstr(at, "<inf> probe: ")) != NULL; at++) {
		shown++;
	}
	zassert_equal((uint32_t)shown + dropped, 1000);
	(void)snprintf(expected, sizeof(expected), "--- %u messages dropped ---\n",
	               (unsigned int)dropped);
	zassert_not_null(strstr(lines, expected), "%s", lines);
	/* The first ones are kept. */
	zassert_not_null(strstr(lines, "probe: 0\n"));
	/* And it goes on. */
	before(NULL);
	LOG_INF("after");
	expect_line("<inf> probe: after\n");
}
