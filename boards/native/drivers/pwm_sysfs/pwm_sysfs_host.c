/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --light pwm:… and its kin: PWM outputs of the board (models/board.h) that are real.
 *
 * A chip may sit on a bus, and a bus may hang. So helpers write, one for the lamp and one for all
 * else. Each output has one job at a time; when it ends, what the board wants by then is written,
 * so a bus that is too slow for a strobe leaves edges out and delays none. An output that fails,
 * does not answer or has gone is away: the device cannot write to it (board_pwm_away), until it has
 * been opened anew.
 */
#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/guard.h"
#include "host/hardware.h"
#include "host/helper.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/reset.h"
#include "host/say.h"
#include "kernel/port.h"
#include "models/board.h"
#include "pwm_channel_host.h"
#include "pwm_options_host.h"

enum {
	CHECK_MS = 100,
	SILENT_CHECKS = 5, /* a write takes less than 500 ms */
	RETRY_CHECKS = 10, /* one that is away is looked for every second */
	FLUSH_MS = 1000,
	GUARD_TRIES = 250, /* for the guard of a light that was killed just now to end */
	GUARD_TRY_US = 20000,
	EXIT_OPTION = 2,
};

enum task {
	TASK_NONE,
	TASK_WRITE,
	TASK_CHECK,
	TASK_OPEN,
};

struct output {
	struct pwm_channel pwm;
	bool is_away;
	bool is_unstarted; /* since this boot: a driver has not started without it */
	bool is_proven;    /* a job has gone well since it was opened */
	uint32_t pulse_ns; /* written, or being written */
	uint32_t waited;   /* checks, for its job or for the next try */
	uint32_t last_ns;  /* wanted when it was last looked at */
	uint32_t pending;  /* changes while one is written: the last of them is written next */
	uint64_t skipped;  /* the others */
	uint64_t losses;
	/* The job under way, and what came of it. */
	struct helper_job job;
	enum task task;
	int error;
	struct host_error reason;
};

static struct output outputs[BOARD_PWM_COUNT];
static struct helper lamp_helper = {.name = "pharos-lamp"};
static struct helper other_helper = {.name = "pharos-pwm"};
static struct guard_output guarded;
static struct loop_timer check;

/* Carried over resets: channels that we have exported. */
static uint32_t exported;

static bool is_wanted(uint32_t channel)
{
	return pwm_places[channel].chip[0] != '\0';
}

/* What the board wants of it now. */
static uint32_t wanted_ns(uint32_t channel)
{
	const uint32_t period_ns = pwm_places[channel].period_ns;
	const uint64_t ppm =
		channel == BOARD_PWM_LAMP ? board.lamp.level_ppm : board.pwm[channel].duty_ppm;
	const uint32_t pulse_ns = pwm_uses[channel].is_ratio
	                                  ? (uint32_t)(period_ns * ppm / 1000000u)
	                                  : board.pwm[channel].pulse_ns;

	return pulse_ns < period_ns ? pulse_ns : period_ns;
}

/* --- the guard's --------------------------------------------------------------------------------
 */

static void make_safe(void)
{
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		if (is_wanted(channel)) {
			pwm_channel_end(&outputs[channel].pwm);
		}
	}
}

static bool keeps(int fd, const char *target)
{
	(void)target;
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		const struct pwm_channel *pwm = &outputs[channel].pwm;

		if (is_wanted(channel) &&
		    (fd == pwm->duty_fd || fd == pwm->enable_fd || fd == pwm->claim_fd)) {
			return true;
		}
	}
	return false;
}

/* --- jobs ---------------------------------------------------------------------------------------
 */

static void follow(uint32_t channel);

/* In the helper. */
static void work(struct helper_job *job)
{
	struct output *output = (struct output *)((char *)job - offsetof(struct output, job));
	const uint32_t channel = (uint32_t)(output - outputs);
	bool is_ours;

	switch (output->task) {
	case TASK_WRITE:
		output->error = pwm_channel_write(&output->pwm, output->pulse_ns);
		break;
	case TASK_CHECK:
		output->error = pwm_channel_check(&output->pwm);
		break;
	case TASK_OPEN:
		output->error = pwm_channel_open(&output->pwm, &pwm_places[channel],
		                                 (exported & (1u << channel)) != 0, &is_ours,
		                                 &output->reason);
		break;
	case TASK_NONE:
		break;
	}
}

static void set_away(struct output *output, int error)
{
	const uint32_t channel = (uint32_t)(output - outputs);

	output->waited = 0;
	if (!output->is_away) {
		output->is_away = true;
		output->losses++;
		board_pwm_away |= 1u << channel;
		host_say("%s: %s/%u is lost: %s; trying again", pwm_uses[channel].name,
		         pwm_places[channel].chip, pwm_places[channel].channel, strerror(-error));
	}
}

static void set_back(struct output *output)
{
	const uint32_t channel = (uint32_t)(output - outputs);

	exported |= output->pwm.is_exported ? 1u << channel : 0;
	output->is_away = false;
	output->is_proven = false;
	output->pulse_ns = 0;
	output->last_ns = 0;
	output->pending = 0;
	board_pwm_away &= ~(1u << channel);
	host_say("%s: %s/%u is back", pwm_uses[channel].name, pwm_places[channel].chip,
	         pwm_places[channel].channel);
	guarded.is_open = true;
	(void)guard_renew();
	if (output->is_unstarted) {
		/* a driver starts only after a reset */
		port_reset(RESET_CAUSE_PIN);
	}
}

static void begin(struct output *output, enum task task);

/* Opening makes it dark. What was written late, to an output that had been given up, is undone at
 * once; after an error there is one try at once, unless the last one led to nothing. */
static void done(struct helper_job *job)
{
	struct output *output = (struct output *)((char *)job - offsetof(struct output, job));
	const enum task task = output->task;
	const bool is_late = output->is_away && task != TASK_OPEN;
	const bool was_proven = output->is_proven;

	output->task = TASK_NONE;
	output->waited = 0;
	if (task == TASK_OPEN) {
		if (output->error == 0) {
			set_back(output);
		}
	} else if (output->error != 0) {
		output->is_proven = false;
		set_away(output, output->error);
	} else {
		output->is_proven = true;
	}
	if (is_late || (output->is_away && was_proven && !output->is_proven)) {
		begin(output, TASK_OPEN);
	}
	follow((uint32_t)(output - outputs));
}

static void begin(struct output *output, enum task task)
{
	output->task = task;
	output->job.work = work;
	output->job.done = done;
	helper_submit(output == &outputs[BOARD_PWM_LAMP] ? &lamp_helper : &other_helper,
	              &output->job);
}

/* The board's output has changed, perhaps. */
static void follow(uint32_t channel)
{
	struct output *output = &outputs[channel];
	const uint32_t pulse_ns = wanted_ns(channel);

	if (!is_wanted(channel) || output->is_away) {
		return;
	}
	output->pending += pulse_ns != output->last_ns ? 1 : 0;
	output->last_ns = pulse_ns;
	if (output->task == TASK_NONE && pulse_ns != output->pulse_ns) {
		output->pulse_ns = pulse_ns;
		output->skipped += output->pending - 1;
		output->pending = 0;
		begin(output, TASK_WRITE);
	} else if (output->task == TASK_NONE) {
		output->skipped += output->pending;
		output->pending = 0;
	}
}

static void check_one(struct output *output)
{
	output->waited++;
	if (output->task != TASK_NONE) {
		if (output->task != TASK_OPEN && output->waited >= SILENT_CHECKS) {
			set_away(output, -ETIMEDOUT);
		}
	} else if (!output->is_away) {
		begin(output, TASK_CHECK);
	} else if (output->waited >= RETRY_CHECKS) {
		begin(output, TASK_OPEN);
	}
}

static void on_check(struct loop_timer *timer)
{
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		if (is_wanted(channel)) {
			check_one(&outputs[channel]);
		}
	}
	loop_timer_start(timer, CHECK_MS);
}

/* --- the module ---------------------------------------------------------------------------------
 */

static int open_output(uint32_t channel, struct host_error *error)
{
	const bool is_ours_to_end = (exported & (1u << channel)) != 0;
	bool is_ours = true;
	int rc = -1;

	for (int i = 0; rc != 0 && is_ours && i < GUARD_TRIES; i++) {
		if (i > 0) {
			usleep(GUARD_TRY_US);
		}
		rc = pwm_channel_open(&outputs[channel].pwm, &pwm_places[channel], is_ours_to_end,
		                      &is_ours, error);
	}
	return rc;
}

/* The one before that has the same place; BOARD_PWM_COUNT: none. */
static uint32_t find_same(uint32_t channel)
{
	uint32_t other = 0;

	while (other < channel && strcmp(outputs[other].pwm.path, outputs[channel].pwm.path) != 0) {
		other++;
	}
	return other < channel ? other : BOARD_PWM_COUNT;
}

static int open_new_output(uint32_t channel, struct host_error *error)
{
	uint32_t other;

	if (pwm_channel_find(&outputs[channel].pwm, &pwm_places[channel], error) != 0) {
		return -1;
	}
	other = find_same(channel);
	return other == BOARD_PWM_COUNT
	               ? open_output(channel, error)
	               : host_error_set(error, "%s: --%s has it", outputs[channel].pwm.path,
	                                pwm_uses[other].name);
}

static int start_output(uint32_t channel)
{
	struct host_error error;

	if (clock_is_virtual() && sysfs_is_real()) {
		(void)fprintf(stderr, "pharos: --%s: a real output needs --time real\n",
		              pwm_uses[channel].name);
		return EXIT_OPTION;
	}
	if (open_new_output(channel, &error) == 0) {
		exported |= outputs[channel].pwm.is_exported ? 1u << channel : 0;
		guarded.is_open = true;
		return 0;
	}
	if (!carry_is_reset()) {
		(void)fprintf(stderr, "pharos: --%s: %s\n", pwm_uses[channel].name, error.text);
		return EXIT_OPTION;
	}
	/* the drivers of the lamp and of the servos want their outputs at start */
	outputs[channel].is_unstarted = channel == BOARD_PWM_LAMP ||
	                                channel == BOARD_PWM_SERVO_PAN ||
	                                channel == BOARD_PWM_SERVO_TILT;
	set_away(&outputs[channel], -ENODEV);
	return 0;
}

/* The dark that off() has asked for is written. */
static void flush(void)
{
	loop_timer_stop(&check);
	board_pwm_outside = NULL;
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		struct output *output = &outputs[channel];
		struct helper *helper = channel == BOARD_PWM_LAMP ? &lamp_helper : &other_helper;

		if (output->pwm.duty_fd >= 0 && helper_finish(helper, FLUSH_MS)) {
			(void)pwm_channel_write(&output->pwm, 0);
		}
	}
}

static void stop(void)
{
	flush();
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		struct pwm_channel *pwm = &outputs[channel].pwm;

		if (pwm->claim_fd >= 0) {
			pwm_channel_end(pwm);
			pwm_channel_close(pwm);
		}
	}
}

static int start_all(void)
{
	int rc = 0;

	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		const int status = is_wanted(channel) ? start_output(channel) : 0;

		rc = rc != 0 ? rc : status;
		if (rc != 0 && !hardware_is_only_off()) {
			return rc;
		}
	}
	return rc != 0 || !guarded.is_open ? rc : guard_renew();
}

static int start(void)
{
	int rc;

	carry_register("pwm", &exported, sizeof(exported));
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		pwm_channel_init(&outputs[channel].pwm);
	}
	guarded.make_safe = make_safe;
	guarded.keeps = keeps;
	guard_add(&guarded);
	if (is_wanted(BOARD_PWM_LAMP)) {
		hardware_lamp("--light");
	}
	rc = start_all();
	if (rc != 0) {
		stop();
		return rc;
	}
	board_pwm_outside = follow;
	check.fire = on_check;
	if (!clock_is_virtual()) {
		loop_timer_start(&check, CHECK_MS);
	}
	return 0;
}

static enum control_result run_pwm(struct control_call *call)
{
	json_t *all = json_object();

	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		const struct output *output = &outputs[channel];
		json_t *one = json_object();

		if (is_wanted(channel)) {
			control_put_string(one, "path", output->pwm.path);
			control_put_bool(one, "present", !output->is_away);
			control_put_integer(one, "period_ns", pwm_places[channel].period_ns);
			control_put_integer(one, "pulse_ns", output->pulse_ns);
			control_put_integer(one, "skipped", (int64_t)output->skipped);
			control_put_integer(one, "losses", (int64_t)output->losses);
			json_object_set(all, pwm_uses[channel].name, one);
		}
		json_decref(one);
	}
	json_object_set_new(call->reply, "outputs", all);
	return CONTROL_OK;
}

static const struct control_op ops[] = {
	{"pwm",
         "the real outputs of --light and its kin: path, present, period_ns, pulse_ns that is "
         "written, skipped changes, losses",
         run_pwm},
	{0},
};

HOST_MODULE(pwm_module) = {
	.name = "pwm",
	.order = HOST_ORDER_BOARD + 1,
	.drives = true,
	.options = pwm_options,
	.ops = ops,
	.start = start,
	.save = flush,
	.stop = stop,
};
