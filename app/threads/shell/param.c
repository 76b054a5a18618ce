/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell commands for the device's parameters: param list, get, set, reset.
 */
#include <errno.h>
#include <string.h>

#include <zephyr/shell/shell.h>

#include "core/param_units.h"
#include "threads/clock.h"
#include "threads/shell/call.h"
#include "threads/shell/names.h"
#include "threads/shell/say.h"

#ifdef CONFIG_PHAROS_PARAM_MEANINGS
#define MEANING_OF(info) ((info)->meaning)
#else
#define MEANING_OF(info) ""
#endif

static void print_param(const struct shell *sh, const struct params *params, uint32_t index)
{
	const struct param_info *const info = params_info(index);
	char value[DECIMAL_TEXT_MAX];
	char min[DECIMAL_TEXT_MAX];
	char max[DECIMAL_TEXT_MAX];
	char fallback[DECIMAL_TEXT_MAX];

	(void)param_print(info, params->values[index], value);
	(void)param_print(info, info->min, min);
	(void)param_print(info, info->max, max);
	(void)param_print(info, info->fallback, fallback);
	shell_print(
		sh, "%-16s %10s %-8s %s to %s, default %s%s%s  %s", info->name, value, info->unit,
		min, max, fallback, (info->flags & PARAM_FLAG_REBOOT) != 0 ? ", after reset" : "",
		(info->flags & PARAM_FLAG_READ_ONLY) != 0 ? ", read-only" : "", MEANING_OF(info));
}

static int copy_params(struct pharos_device *device, void *argument)
{
	*(struct params *)argument = device->params;
	return 0;
}

/* Those whose name begins with the word; how many there were, or -EAGAIN. */
static int print_matching(const struct shell *sh, const char *word)
{
	struct params params;
	int found = 0;

	if (!shell_call(sh, copy_params, &params, NULL)) {
		return -EAGAIN;
	}
	for (uint32_t index = 0; index < PARAM_COUNT; index++) {
		if (names_begin(params_info(index)->name, word)) {
			print_param(sh, &params, index);
			found++;
		}
	}
	return found;
}

static int cmd_param_list(const struct shell *sh, size_t argc, char **argv)
{
	return MIN(print_matching(sh, ""), 0);
}

static int cmd_param_get(const struct shell *sh, size_t argc, char **argv)
{
	const int found = print_matching(sh, argv[1]);

	if (found == 0) {
		shell_error(sh, "no parameter begins with '%s' (see: param list)", argv[1]);
		return -ENOENT;
	}
	return MIN(found, 0);
}

/* PARAM_COUNT: there is none of that name. */
static uint32_t find(const char *name)
{
	uint32_t index = 0;

	while (index < PARAM_COUNT && !names_equal(params_info(index)->name, name)) {
		index++;
	}
	return index;
}

struct param_request {
	uint32_t index;
	int32_t value;
	enum params_result result;
};

static int set_param(struct pharos_device *device, void *argument)
{
	struct param_request *const request = argument;

	request->result = pharos_device_set_param(device, clock_now_us(), &shell_who,
	                                          request->index, request->value);
	return 0;
}

static int cmd_param_set(const struct shell *sh, size_t argc, char **argv)
{
	struct param_request request = {.index = find(argv[1]), .result = PARAMS_UNKNOWN};
	const struct param_info *const info = params_info(request.index);

	if (info != NULL && !param_parse(info, argv[2], strlen(argv[2]), &request.value)) {
		shell_error(sh, "'%s' is not a %s", argv[2],
		            info->unit[0] == '\0' ? "whole number" : "number, such as 2 or 0.5");
		return -EINVAL;
	}
	if (!shell_call(sh, set_param, &request, NULL)) {
		return -EAGAIN;
	}
	switch (request.result) {
	case PARAMS_OK:
		return MIN(print_matching(sh, argv[1]), 0);
	case PARAMS_UNKNOWN:
		shell_error(sh, "no parameter '%s' (see: param list)", argv[1]);
		return -ENOENT;
	case PARAMS_READ_ONLY:
		shell_error(sh, "%s is read-only", argv[1]);
		return -EACCES;
	case PARAMS_OUT_OF_RANGE:
		shell_error(sh, "%s is out of range (see: param get %s)", argv[2], argv[1]);
		return -ERANGE;
	case PARAMS_CONFLICT:
		shell_error(sh, "%s does not go with a related parameter (see: param get %.4s)",
		            argv[2], argv[1]);
		return -ERANGE;
	case PARAMS_FORBIDDEN:
		shell_error(sh, "the shell is excluded (see: param get LGT_SRC_EXCL)");
		return -EACCES;
	}
	return -EINVAL;
}

static int reset_params(struct pharos_device *device, void *argument)
{
	return pharos_device_reset_params(device, clock_now_us(), &shell_who) ? 0 : -EACCES;
}

static int cmd_param_reset(const struct shell *sh, size_t argc, char **argv)
{
	int result;

	if (!shell_call(sh, reset_params, NULL, &result)) {
		return -EAGAIN;
	}
	if (result != 0) {
		return say_result(sh, DEVICE_EXCLUDED, "light status");
	}
	shell_print(sh, "all parameters are at their defaults");
	return 0;
}

/* For the Tab key. */
static void name_get(size_t index, struct shell_static_entry *entry)
{
	*entry = (struct shell_static_entry){
		.syntax = index < PARAM_COUNT ? params_info(index)->name : NULL,
	};
}

SHELL_DYNAMIC_CMD_CREATE(param_names, name_get);

SHELL_STATIC_SUBCMD_SET_CREATE(
	param_commands,
	SHELL_CMD_ARG(get, &param_names, "NAME  one parameter, or all that begin so", cmd_param_get, 2, 0),
	SHELL_CMD_ARG(list, NULL, "All parameters", cmd_param_list, 1, 0),
	SHELL_CMD_ARG(reset, NULL, "Everything back to its default", cmd_param_reset, 1, 0),
	SHELL_CMD_ARG(set, &param_names, "NAME VALUE  change one parameter", cmd_param_set, 3, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(param, &param_commands, "Parameters", NULL);
