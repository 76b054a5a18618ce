/* SPDX-License-Identifier: Apache-2.0 */
#include "host/command_line.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/config.h"
#include "host/module.h"

enum {
	HELP_COLUMN = 26,
	OPTIONS_MAX = 128,
};

struct own {
	const char *config; /* NULL: no file */
	bool is_check;
	bool is_dump;
};

static void print_option(const char *name, const char *arg, const char *help)
{
	char left[96];
	int width;

	snprintf(left, sizeof(left), "  --%s%s%s", name, arg != NULL ? " " : "",
	         arg != NULL ? arg : "");
	width = printf("%s", left);
	if (width >= HELP_COLUMN) {
		printf("\n");
		width = 0;
	}
	for (const char *line = help; line != NULL;) {
		const char *end = strchr(line, '\n');
		const int length = end != NULL ? (int)(end - line) : (int)strlen(line);

		printf("%*s%.*s\n", HELP_COLUMN - width, "", length, line);
		width = 0;
		line = end != NULL ? end + 1 : NULL;
	}
}

static _Noreturn void print_help(const char *program)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);

	printf("%s: a smart drone light on the native board\n\n"
	       "usage: %s [option…]\n\ngeneral\n",
	       program, program);
	print_option("help", NULL, "this text");
	print_option("version", NULL, "the version");
	print_option("config", "FILE",
	             "read options from FILE, a line NAME = VALUE each; those of the\n"
	             "command line take their place");
	print_option("check", NULL, "only check the options, those of FILE too, and end");
	print_option("dump-config", NULL, "print the options as such a file, and end");
	for (size_t i = 0; i < count; i++) {
		if (modules[i]->options == NULL) {
			continue;
		}
		printf("\n%s\n", modules[i]->name);
		for (const struct host_option *o = modules[i]->options; o->name != NULL; o++) {
			print_option(o->name, o->arg, o->help);
		}
	}
	exit(0);
}

static const struct host_option *find_option(const char *name, size_t length)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);

	for (size_t i = 0; i < count; i++) {
		const struct host_option *o = modules[i]->options;

		for (; o != NULL && o->name != NULL; o++) {
			if (strlen(o->name) == length && memcmp(o->name, name, length) == 0) {
				return o;
			}
		}
	}
	return NULL;
}

static _Noreturn void fail(const char *program, const char *text)
{
	fprintf(stderr, "%s: %s\n", program, text);
	exit(2);
}

/* --- what is in force ---------------------------------------------------------------------------
 */

/* Options that have been given, each once. */
static struct {
	const struct host_option *option;
	const char *value; /* NULL: it takes none */
} given[OPTIONS_MAX];
static size_t given_count;

static size_t find_given(const struct host_option *option)
{
	size_t i = 0;

	while (i < given_count && given[i].option != option) {
		i++;
	}
	return i;
}

static void remember(const struct host_option *option, const char *value)
{
	const size_t i = find_given(option);

	if (i == OPTIONS_MAX) {
		abort();
	}
	given[i].option = option;
	given[i].value = value;
	given_count += i == given_count ? 1 : 0;
}

static void dump_option(const struct host_option *option)
{
	const size_t i = find_given(option);

	if (i == given_count) {
		printf("# %s = %s\n", option->name, option->arg != NULL ? option->arg : "yes");
	} else {
		printf("%s = %s\n", option->name, option->arg != NULL ? given[i].value : "yes");
	}
}

/* Those that have not been given as comments. */
static _Noreturn void dump(void)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);

	for (size_t i = 0; i < count; i++) {
		const struct host_option *o = modules[i]->options;

		if (o != NULL) {
			printf("# --- %s\n", modules[i]->name);
		}
		for (; o != NULL && o->name != NULL; o++) {
			dump_option(o);
		}
	}
	exit(0);
}

/* A line of the file. */
static int take(const char *name, const char *value, struct host_error *error)
{
	const struct host_option *option = find_option(name, strlen(name));
	const bool is_yes = strcmp(value, "yes") == 0;

	if (option == NULL) {
		return host_error_set(error, "unknown option; --help lists all");
	}
	if (option->arg == NULL && !is_yes && strcmp(value, "no") != 0) {
		return host_error_set(error, "\"%.40s\" is neither yes nor no", value);
	}
	if (find_given(option) < given_count || (option->arg == NULL && !is_yes)) {
		return 0; /* the command line has it; or it is off */
	}
	if (option->parse(option->arg != NULL ? value : NULL, error) != 0) {
		return -1;
	}
	remember(option, value);
	return 0;
}

/* --- the command line ---------------------------------------------------------------------------
 */

/* Parses argv[i]; how many words it took. */
static int parse_one(const char *program, int left, char *const word[])
{
	const char *name = word[0];
	const char *equals = strchr(name, '=');
	const size_t length = equals != NULL ? (size_t)(equals - name) : strlen(name);
	const struct host_option *option = NULL;
	struct host_error error;
	struct host_error reason;
	const char *value = equals != NULL ? equals + 1 : NULL;
	int used = 1;

	if (strncmp(name, "--", 2) == 0) {
		option = find_option(name + 2, length - 2);
	}
	if (option == NULL) {
		host_error_set(&error, "unknown option \"%.80s\"; --help lists all", name);
		fail(program, error.text);
	}
	if (option->arg == NULL && value != NULL) {
		host_error_set(&error, "--%s takes no value", option->name);
		fail(program, error.text);
	}
	if (option->arg != NULL && value == NULL) {
		if (left < 2) {
			host_error_set(&error, "--%s needs a value: --%s %s", option->name,
			               option->name, option->arg);
			fail(program, error.text);
		}
		value = word[1];
		used = 2;
	}
	if (option->parse(value, &reason) != 0) {
		host_error_set(&error, "--%s: %.200s", option->name, reason.text);
		fail(program, error.text);
	}
	remember(option, value);
	return used;
}

/* Options of the command line itself; how many words it took, 0: it is none of them. */
static int parse_own(const char *program, struct own *own, int left, char *const word[])
{
	if (strcmp(word[0], "--check") == 0) {
		own->is_check = true;
		return 1;
	}
	if (strcmp(word[0], "--dump-config") == 0) {
		own->is_dump = true;
		return 1;
	}
	if (strncmp(word[0], "--config=", 9) == 0) {
		own->config = word[0] + 9;
		return 1;
	}
	if (strcmp(word[0], "--config") != 0) {
		return 0;
	}
	if (left < 2) {
		fail(program, "--config needs a value: --config FILE");
	}
	own->config = word[1];
	return 2;
}

void command_line_parse(int argc, char *const argv[])
{
	const char *slash = strrchr(argv[0], '/');
	const char *program = slash != NULL ? slash + 1 : argv[0];
	struct own own = {0};
	struct host_error error;

	for (int i = 1; i < argc; i++) {
		if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
			print_help(program);
		}
		if (strcmp(argv[i], "--version") == 0) {
			printf("pharos %s (native)\n", PHAROS_VERSION);
			exit(0);
		}
	}
	for (int i = 1; i < argc;) {
		const int used = parse_own(program, &own, argc - i, &argv[i]);

		i += used > 0 ? used : parse_one(program, argc - i, &argv[i]);
	}
	if (own.config != NULL && config_read(own.config, take, &error) != 0) {
		fail(program, error.text);
	}
	if (own.is_dump) {
		dump();
	}
	if (own.is_check) {
		printf("ok\n");
		exit(0);
	}
}
