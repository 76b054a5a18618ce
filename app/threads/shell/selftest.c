/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command selftest: runs the self-test and says what it found.
 */
#include <errno.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>

#include "core/decimal.h"
#include "threads/clock.h"
#include "threads/shell/call.h"
#include "threads/shell/say.h"

#define LAMP    0
#define POLL_MS 50

struct request {
	uint32_t peak_ppm;
	enum self_test_state obstacle;
	enum device_result result;
};

static int begin(struct pharos_device *device, void *argument)
{
	struct request *const request = argument;

	request->result = pharos_device_test(device, clock_now_us(), &shell_who, LAMP,
	                                     request->peak_ppm, &request->obstacle);
	return 0;
}

static int state(struct pharos_device *device, void *argument)
{
	return (int)device->lamps[LAMP].self_test.state;
}

static int parse_peak(const struct shell *sh, const char *text, uint32_t *peak_ppm)
{
	int64_t parsed;

	if (!decimal_parse_exact(text, PPM_PER_PERCENT_DECIMALS, &parsed) || parsed <= 0 ||
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
	if (!shell_call(sh, begin, &request, NULL)) {
		return -EAGAIN;
	}
	if (request.obstacle != SELF_TEST_NONE) {
		return say_end(sh, request.obstacle);
	}
	if (request.result != DEVICE_ACCEPTED) {
		return say_result(sh, request.result, "light status");
	}
	do {
		k_msleep(POLL_MS);
	} while (shell_call(sh, state, NULL, &answer) && answer == SELF_TEST_RUNNING);
	return say_end(sh, (enum self_test_state)answer);
}

SHELL_CMD_ARG_REGISTER(selftest, NULL,
                       "[PERCENT]  sweep the lamp, up to full brightness or that, and check it",
                       cmd_selftest, 1, 1);
