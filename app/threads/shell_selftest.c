/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command selftest: runs the self-test and says what it found.
 */
#include <errno.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>

#include "threads/clock.h"
#include "threads/fixed.h"
#include "threads/shell_call.h"

#define PPM_PER_PERCENT_DECIMALS 4 /* 1 % = 10 000 ppm */
#define POLL_MS                  50

struct request {
	uint32_t peak_ppm;
	enum self_test_state obstacle;
	enum arbiter_verdict verdict;
	enum illuminator_result result;
};

/* In the command thread; 1: it runs. */
static int begin(struct command *command, void *argument)
{
	struct request *const request = argument;
	const struct illuminator_event first = self_test_first();

	request->obstacle = self_test_obstacle(&command->self_test, &command->illuminator);
	if (request->obstacle != SELF_TEST_NONE) {
		return 0;
	}
	request->verdict = command_apply(command, ARBITER_SOURCE_SHELL, &first, &request->result);
	if (request->verdict != ARBITER_GRANTED || request->result != ILLUMINATOR_ACCEPTED) {
		return 0;
	}
	self_test_begin(&command->self_test, clock_now_us(), request->peak_ppm);
	return 1;
}

static int state(struct command *command, void *argument)
{
	return (int)command->self_test.state;
}

static int parse_peak(const struct shell *sh, const char *text, uint32_t *peak_ppm)
{
	int64_t parsed;

	if (!fixed_parse(text, PPM_PER_PERCENT_DECIMALS, &parsed) || parsed <= 0 ||
	    parsed > PPM_ONE) {
		shell_error(sh, "'%s' is not a brightness above 0, up to 100 percent", text);
		return -EINVAL;
	}
	*peak_ppm = (uint32_t)parsed;
	return 0;
}

static int say_end(const struct shell *sh, enum self_test_state end)
{
	if (end == SELF_TEST_PASSED) {
		shell_print(sh, "%s", self_test_text(end));
		return 0;
	}
	shell_error(sh, "%s", self_test_text(end));
	return -EIO;
}

static int cmd_selftest(const struct shell *sh, size_t argc, char **argv)
{
	struct request request = {.peak_ppm = PPM_ONE};
	const int error = argc > 1 ? parse_peak(sh, argv[1], &request.peak_ppm) : 0;
	int answer;

	if (error != 0) {
		return error;
	}
	if (!shell_call(sh, begin, &request, &answer)) {
		return -EAGAIN;
	}
	if (answer == 0) {
		if (request.obstacle == SELF_TEST_NONE) {
			shell_error(sh,
			            "not now: another source is in command (see: light status)");
			return -EBUSY;
		}
		return say_end(sh, request.obstacle);
	}
	do {
		k_msleep(POLL_MS);
	} while (shell_call(sh, state, NULL, &answer) && answer == SELF_TEST_RUNNING);
	return say_end(sh, (enum self_test_state)answer);
}

SHELL_CMD_ARG_REGISTER(selftest, NULL,
                       "[PERCENT]  sweep the lamp, up to full brightness or that, and check it",
                       cmd_selftest, 1, 1);
