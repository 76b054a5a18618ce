/* SPDX-License-Identifier: Apache-2.0 */
#include "host/command_line.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/module.h"

enum {
	HELP_COLUMN = 26
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
	return used;
}

void command_line_parse(int argc, char *const argv[])
{
	const char *slash = strrchr(argv[0], '/');
	const char *program = slash != NULL ? slash + 1 : argv[0];

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
		i += parse_one(program, argc - i, &argv[i]);
	}
}
