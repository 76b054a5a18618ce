/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a line to a command: words, dispatch, argument counts, help, history. Return values are
 * those that <zephyr/shell/shell.h> promises: 1 help printed, -EINVAL (-22) bad count, -ENOEXEC
 * (-8) not executed.
 */
#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell_dummy.h>
#include <zephyr/ztest.h>

#define WORDS_MAX 24

static void expect_str(const char *text, const char *expected)
{
	zassert_equal(strcmp(text, expected), 0, "\"%s\" is not \"%s\"", text, expected);
}

static const struct shell *sh;

/* What the last command was given. */
static size_t seen_argc;
static char seen[WORDS_MAX][64];
static bool seen_null;

static int cmd_see(const struct shell *shell, size_t argc, char **argv)
{
	seen_argc = argc;
	seen_null = argv[argc] == NULL;
	for (size_t i = 0; i < argc && i < WORDS_MAX; i++) {
		(void)strncpy(seen[i], argv[i], sizeof(seen[i]) - 1);
	}
	return 7;
}

static int cmd_nest(const struct shell *shell, size_t argc, char **argv)
{
	return shell_execute_cmd(shell, "see");
}

static int cmd_print(const struct shell *shell, size_t argc, char **argv)
{
	shell_print(shell, "plain %d", 1);
	shell_error(shell, "error %s", "two");
	shell_fprintf(shell, SHELL_NORMAL, "no end");
	return 0;
}

static int cmd_long(const struct shell *shell, size_t argc, char **argv)
{
	shell_print(shell, "%*d", CONFIG_SHELL_PRINTF_BUFF_SIZE + 10, 1);
	return 0;
}

static int cmd_dump(const struct shell *shell, size_t argc, char **argv)
{
	shell_hexdump(shell, (const uint8_t *)"0123456789abcdef\x01z", 18);
	return 0;
}

static void get_colour(size_t idx, struct shell_static_entry *entry)
{
	static const char *const names[] = {"amber", "blue"};

	entry->syntax = idx < ARRAY_SIZE(names) ? names[idx] : NULL;
	entry->handler = cmd_see;
	entry->help = "A colour";
	entry->subcmd = NULL;
}

SHELL_DYNAMIC_CMD_CREATE(colour_commands, get_colour);

SHELL_STATIC_SUBCMD_SET_CREATE(deep_commands,
	SHELL_CMD_ARG(end, NULL, "The end", cmd_see, 1, 1),
	SHELL_SUBCMD_SET_END
);
SHELL_STATIC_SUBCMD_SET_CREATE(tree_commands,
	SHELL_CMD(zeta, NULL, "Last", cmd_see),
	SHELL_CMD(alpha, NULL, "First\nsecond line", cmd_see),
	SHELL_CMD(deep, &deep_commands, "Deeper", NULL),
	SHELL_CMD(mute, &deep_commands, NULL, NULL),
	SHELL_COND_CMD(CONFIG_THERE_IS_NO_SUCH_OPTION, gone, NULL, "Not built", cmd_see),
	SHELL_SUBCMD_SET_END
);
SHELL_STATIC_SUBCMD_SET_CREATE(both_commands,
	SHELL_CMD_ARG(sub, NULL, "Below", cmd_see, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_CMD_REGISTER(see, NULL, "Sees its words", cmd_see);
SHELL_CMD_ARG_REGISTER(one, NULL, "One word, one more", cmd_see, 1, 1);
SHELL_CMD_ARG_REGISTER(two, NULL, NULL, cmd_see, 2, 0);
SHELL_CMD_ARG_REGISTER(many, NULL, "Any number", cmd_see, 2, SHELL_OPT_ARG_CHECK_SKIP);
SHELL_CMD_ARG_REGISTER(raw, NULL, "Raw rest", cmd_see, 2, SHELL_OPT_ARG_RAW);
SHELL_CMD_REGISTER(tree, &tree_commands, "A tree", NULL);
SHELL_CMD_ARG_REGISTER(both, &both_commands, "Both", cmd_see, 1, 1);
SHELL_CMD_REGISTER(colour, &colour_commands, "Colours", NULL);
SHELL_CMD_REGISTER(silent, &both_commands, NULL, NULL);
SHELL_CMD_REGISTER(nest, NULL, NULL, cmd_nest);
SHELL_CMD_REGISTER(print, NULL, NULL, cmd_print);
SHELL_CMD_REGISTER(overlong, NULL, NULL, cmd_long);
SHELL_CMD_REGISTER(dump, NULL, NULL, cmd_dump);

static const char *output(void)
{
	size_t size;

	return shell_backend_dummy_get_output(sh, &size);
}

static void expect(const char *line, int result)
{
	const int rc = shell_execute_cmd(sh, line);

	zassert_equal(rc, result, "%s: %d, expected %d", line, rc, result);
}

static void expect_text(const char *text)
{
	const char *out = output();

	zassert_not_null(strstr(out, text), "no \"%s\" in \"%s\"", text, out);
}

static void *setup(void)
{
	sh = shell_backend_dummy_get_ptr();
	zassert_true(shell_ready(sh));
	/* Only what commands print, with nothing around it. */
	(void)shell_echo_set(sh, false);
	return NULL;
}

static void before(void *fixture)
{
	seen_argc = 0;
	memset(seen, 0, sizeof(seen));
	shell_backend_dummy_clear_output(sh);
}

ZTEST_SUITE(shell, NULL, setup, before, NULL, NULL);

ZTEST(shell, test_words_are_split_at_blanks)
{
	expect("  see  a\tbc   d ", 7);
	zassert_equal(seen_argc, 4);
	expect_str(seen[0], "see");
	expect_str(seen[1], "a");
	expect_str(seen[2], "bc");
	expect_str(seen[3], "d");
	zassert_true(seen_null);
}

ZTEST(shell, test_quotes_and_backslashes)
{
	expect("see \"a b\" 'c \"d' e\\ f \"g\\\"h\" x'y'z \"\" '\\n'", 7);
	zassert_equal(seen_argc, 8);
	expect_str(seen[1], "a b");
	expect_str(seen[2], "c \"d");
	expect_str(seen[3], "e f");
	expect_str(seen[4], "g\"h");
	expect_str(seen[5], "xyz");
	expect_str(seen[6], "");
	expect_str(seen[7], "\\n");
}

ZTEST(shell, test_open_quote_is_refused)
{
	expect("see \"a b", -ENOEXEC);
	expect_text("not terminated: \"");
	expect("see 'a", -ENOEXEC);
	zassert_equal(seen_argc, 0);
}

ZTEST(shell, test_empty_line)
{
	expect("", -ENOEXEC);
	expect("   ", -ENOEXEC);
	expect_str(output(), "");
}

ZTEST(shell, test_unknown_command)
{
	expect("sea", -ENOEXEC);
	expect_text("sea: command not found\n");
	expect("se", -ENOEXEC);
	expect("\"\"", -ENOEXEC);
}

ZTEST(shell, test_argument_counts)
{
	expect("one", 7);
	expect("one 1", 7);
	expect("one 1 2", -EINVAL);
	expect_text("one: wrong parameter count\n");
	expect("two", -EINVAL);
	expect("two 1", 7);
	expect("two 1 2", -EINVAL);
	expect("many", -EINVAL);
	expect("many 1", 7);
	expect("many 1 2 3 4 5 6 7 8", 7);
	zassert_equal(seen_argc, 9);
	/* mandatory 0: not checked */
	expect("see 1 2 3 4", 7);
}

ZTEST(shell, test_wrong_count_prints_the_help)
{
	expect("one 1 2", -EINVAL);
	expect_text("one - One word, one more\n");
}

ZTEST(shell, test_most_words)
{
	zassert_equal(CONFIG_SHELL_ARGC_MAX, 20);
	expect("see 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19", 7);
	zassert_equal(seen_argc, 20);
	expect("see 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20", -ENOEXEC);
}

ZTEST(shell, test_raw_rest)
{
	expect("raw a   b \"\" 'c", 7);
	zassert_equal(seen_argc, 3);
	expect_str(seen[1], "a");
	expect_str(seen[2], "b \"\" 'c");
	expect("raw a", 7);
	zassert_equal(seen_argc, 2);
	expect("raw a   ", 7);
	zassert_equal(seen_argc, 2);
	expect("raw", -EINVAL);
}

ZTEST(shell, test_subcommands)
{
	expect("tree alpha 1 2", 7);
	zassert_equal(seen_argc, 3);
	expect_str(seen[0], "alpha");
	expect("tree deep end x", 7);
	zassert_equal(seen_argc, 2);
	expect_str(seen[0], "end");
	expect("tree deep end x y", -EINVAL);
	expect("tree gone", SHELL_CMD_HELP_PRINTED);
	zassert_equal(seen_argc, 2);
}

ZTEST(shell, test_last_word_with_a_function_wins)
{
	expect("both", 7);
	expect_str(seen[0], "both");
	expect("both sub", 7);
	expect_str(seen[0], "sub");
	zassert_equal(seen_argc, 1);
	expect("both other", 7);
	expect_str(seen[0], "both");
	expect_str(seen[1], "other");
	/* after an argument, subcommands are arguments too */
	expect("both other sub", -EINVAL);
}

ZTEST(shell, test_dynamic_subcommands)
{
	expect("colour blue", 7);
	expect_str(seen[0], "blue");
	expect("colour amber 1", 7);
	expect("colour red", SHELL_CMD_HELP_PRINTED);
	expect("colour", SHELL_CMD_HELP_PRINTED);
	expect_text("  blue   A colour\n");
}

ZTEST(shell, test_missing_subcommand_prints_the_help)
{
	expect("tree", SHELL_CMD_HELP_PRINTED);
	expect_str(output(), "tree - A tree\n"
	                     "Subcommands:\n"
	                     "  alpha  First\n"
	                     "         second line\n"
	                     "  deep   Deeper\n"
	                     "  mute\n"
	                     "  zeta   Last\n");
	expect("tree nowhere", SHELL_CMD_HELP_PRINTED);
	expect_text("nowhere: unknown subcommand\n");
	expect("silent", -ENOEXEC);
	expect_text("Please specify a subcommand.\n");
}

ZTEST(shell, test_help_options)
{
	expect("see -h", SHELL_CMD_HELP_PRINTED);
	expect_text("see - Sees its words\n");
	expect("see a b --help", SHELL_CMD_HELP_PRINTED);
	expect("tree deep -h", SHELL_CMD_HELP_PRINTED);
	expect_text("deep - Deeper\n");
	zassert_equal(seen_argc, 0);
	/* only a whole word */
	expect("see -help", 7);
}

ZTEST(shell, test_output)
{
	expect("print", 0);
	/* The line that was not ended is ended where the next thing starts; here nothing follows.
	 */
	expect_str(output(), "plain 1\nerror two\nno end");
}

ZTEST(shell, test_output_longer_than_the_buffer_is_cut)
{
	size_t size;
	const char *out;

	expect("overlong", 0);
	out = shell_backend_dummy_get_output(sh, &size);
	zassert_equal(size, CONFIG_SHELL_PRINTF_BUFF_SIZE - 1);
	expect_str(&out[size - 4], "...\n");
}

ZTEST(shell, test_hexdump)
{
	expect("dump", 0);
	/* layout as upstream's shell_hexdump_line: offset, two groups of eight, text */
	expect_text(
		"00000000: 30 31 32 33 34 35 36 37  38 39 61 62 63 64 65 66 |0123456789abcdef|");
	expect("dump", 0);
	expect_text("00000010: 01 7a ");
	expect("dump", 0);
	expect_text("|.z              |");
}

ZTEST(shell, test_command_within_a_command_is_refused)
{
	expect("nest", -EDEADLK);
	zassert_equal(seen_argc, 0);
}

ZTEST(shell, test_line_longer_than_the_buffer_is_refused)
{
	char line[CONFIG_SHELL_CMD_BUFF_SIZE + 1];

	memset(line, 'x', sizeof(line));
	memcpy(line, "see ", 4);
	line[CONFIG_SHELL_CMD_BUFF_SIZE] = '\0';
	expect(line, -ENOEXEC);
	line[CONFIG_SHELL_CMD_BUFF_SIZE - 1] = '\0';
	expect(line, 7);
}

ZTEST(shell, test_return_value_is_kept)
{
	expect("see", 7);
	zassert_equal(shell_get_return_value(sh), 7);
	expect("retval", 0);
	expect_text("7\n");
}

static void type(const char *keys)
{
	zassert_equal(shell_backend_dummy_push_input(sh, keys, strlen(keys)), strlen(keys));
	/* The shell's thread runs. */
	k_sleep(K_MSEC(1));
}

ZTEST(shell, test_lines_without_a_terminal)
{
	type("see a b\n");
	zassert_equal(seen_argc, 3);
	type("see a\r\nsee b c d\r\n");
	zassert_equal(seen_argc, 4);
	/* no echo, no prompt, no history */
	expect_str(output(), "");
	type("history\n");
	expect_str(output(), "");
	/* in parts; control characters are no part of a line */
	type("se");
	type("e x\x7f\x01y");
	zassert_equal(seen_argc, 4);
	type("\n");
	zassert_equal(seen_argc, 2);
	expect_str(seen[1], "xy");
}

ZTEST(shell, test_overlong_line_is_not_executed)
{
	for (int i = 0; i < CONFIG_SHELL_CMD_BUFF_SIZE; i += 4) {
		type("see ");
	}
	type("\n");
	zassert_equal(seen_argc, 0);
	expect_text("not executed");
	type("see\n");
	zassert_equal(seen_argc, 1);
}

ZTEST(shell, test_help_lists_commands_in_order)
{
	const char *out;
	const char *both;
	const char *tree;

	expect("help", 0);
	out = output();
	both = strstr(out, "\n  both ");
	tree = strstr(out, "\n  tree ");
	zassert_not_null(both);
	zassert_not_null(tree);
	zassert_true(both < tree);
	expect("help me", -EINVAL);
}

ZTEST(shell, test_kernel_threads)
{
	const char *out;

	expect("kernel threads", 0);
	out = output();
	zassert_not_null(strstr(out, "shell_dummy"), "%s", out);
	zassert_not_null(strstr(out, "main"), "%s", out);
	expect("kernel uptime", 0);
	expect_text("Uptime: ");
	expect("kernel stacks", 0);
	expect_text(" unused ");
}
