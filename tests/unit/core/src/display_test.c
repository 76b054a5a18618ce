/* SPDX-License-Identifier: Apache-2.0 */
#include "core/display.h"

#include <string.h>

#include <zephyr/ztest.h>

static struct display display;

static void before(void *fixture)
{
	display_init(&display);
}

ZTEST_SUITE(core_display, NULL, NULL, before, NULL, NULL);

static bool write_line(uint32_t op, const char *text)
{
	return display_command(&display, op, text, strlen(text));
}

static void expect(size_t line, const char *text)
{
	zassert_equal(strlen(text), DISPLAY_COLUMNS);
	zassert_mem_equal(display.lines[line], text, DISPLAY_COLUMNS);
}

ZTEST(core_display, test_starts_off_and_empty)
{
	zassert_false(display.on);
	expect(0, "                ");
	expect(1, "                ");
}

ZTEST(core_display, test_lines_are_written_apart)
{
	zassert_true(write_line(DISPLAY_OP_WRITE0, "depth 12.5 m"));
	zassert_true(write_line(DISPLAY_OP_WRITE1, "ok"));
	expect(0, "depth 12.5 m    ");
	expect(1, "ok              ");
	zassert_true(write_line(DISPLAY_OP_WRITE0, ""));
	expect(0, "                ");
	expect(1, "ok              ");
}

ZTEST(core_display, test_long_lines_are_cut_and_strange_bytes_shown_as_question_marks)
{
	zassert_true(write_line(DISPLAY_OP_WRITE0, "0123456789abcdefghij"));
	zassert_true(display_command(&display, DISPLAY_OP_WRITE1, "a\0\n\xff~", 5));
	expect(0, "0123456789abcdef");
	expect(1, "a???~           ");
}

ZTEST(core_display, test_on_off_and_clear)
{
	zassert_true(write_line(DISPLAY_OP_WRITE0, "x"));
	zassert_true(write_line(DISPLAY_OP_ON, "ignored"));
	zassert_true(display.on);
	zassert_true(write_line(DISPLAY_OP_OFF, ""));
	zassert_false(display.on);
	expect(0, "x               ");
	zassert_true(write_line(DISPLAY_OP_CLEAR, ""));
	expect(0, "                ");
	zassert_false(display.on);
}

ZTEST(core_display, test_unknown_op_is_refused)
{
	zassert_false(write_line(5, "x"));
	expect(0, "                ");
}
