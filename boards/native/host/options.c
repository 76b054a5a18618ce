/* SPDX-License-Identifier: Apache-2.0 */
#include "host/options.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "host/module.h"
#include "host/version.h"

enum {
	HELP_COLUMN = 26
};

int parse_number(const char *text, uint64_t low, uint64_t high, uint64_t *number,
                 struct host_error *error)
{
	char *end;
	unsigned long long value;

	errno = 0;
	value = strtoull(text, &end, 10);
	if (!isdigit((unsigned char)text[0]) || *end != '\0' || errno != 0 || value < low ||
	    value > high) {
		return host_error_set(
			error, "\"%.60s\" is not a whole number from %" PRIu64 " to %" PRIu64, text,
			low, high);
	}
	*number = value;
	return 0;
}

int parse_duration_us(const char *text, uint64_t *us, struct host_error *error)
{
	static const struct {
		const char *unit;
		double us;
	} units[] = {{"us", 1},     {"ms", 1e3},   {"s", 1e6},
	             {"min", 60e6}, {"h", 3600e6}, {"d", 86400e6}};
	char *end;
	const double value = strtod(text, &end);

	if (isdigit((unsigned char)text[0]) && isfinite(value)) {
		for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); i++) {
			/* A thousand years of microseconds still fit, exactly enough, in a double.
			 */
			if (strcmp(end, units[i].unit) == 0 && value * units[i].us < 3.2e16) {
				*us = (uint64_t)llround(value * units[i].us);
				return 0;
			}
		}
	}
	return host_error_set(error, "\"%.60s\" is not a duration such as 500ms, 2s, 10min or 24h",
	                      text);
}

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

void options_parse(int argc, char *const argv[])
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
