/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/command.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/probe.h>

#include "threads/actuation.h"
#include "threads/can_node.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/gimbal_node.h"
#include "threads/imc_node.h"
#include "threads/inputs.h"
#include "threads/mavlink_node.h"
#include "threads/startup.h"
#include "threads/storage.h"
#include "threads/strobe.h"
#include "threads/supervisor.h"
#include "threads/thermal.h"
#include "threads/uart_link.h"

LOG_MODULE_REGISTER(command);

enum item_kind {
	ITEM_FRAME,
	ITEM_CAN,
	ITEM_IMC,
	ITEM_THERMAL,
	ITEM_CALL,
	ITEM_WAKE,
};

/* A function to run in the command thread, on its caller's stack. */
struct call {
	int (*function)(struct command *command, void *argument);
	void *argument;
	int result;
	struct k_sem done;
};

struct item {
	enum item_kind kind;
	union {
		struct link_frame *frame;
		struct dronecan_frame *can;
		struct imc_frame *imc;
		struct thermal_report thermal;
		struct call *call;
	};
};

K_MSGQ_DEFINE(queue, sizeof(struct item), COMMAND_QUEUE_MAX, 8);

static struct command command;
static struct command_stats stats;
static atomic_t running;
static uint32_t shown_revision;

/* --- performing what the core and the protocols returned -------------------------------------- */

static void show_settings(void)
{
	const struct illuminator_settings *const now = &command.illuminator.settings;

	probe_set(devices.probe, PROBE_ENABLE, now->enable);
	probe_set(devices.probe, PROBE_MODE, now->mode);
	probe_set(devices.probe, PROBE_BRIGHTNESS_PPM, now->brightness_ppm);
	probe_set(devices.probe, PROBE_STROBE_PERIOD_US, now->strobe_period_us);
	probe_set(devices.probe, PROBE_STROBE_DUTY_PPM, now->duty_ppm);
}

static void notice(const struct illuminator_notice *notice)
{
	if (notice->kind == ILLUMINATOR_NOTICE_SENSOR_FAILED) {
		LOG_WRN("%s: %s", illuminator_notice_text(notice->kind),
		        thermal_fault_name(notice->fault));
	} else {
		LOG_WRN("%s", illuminator_notice_text(notice->kind));
	}
	can_node_log(illuminator_notice_text(notice->kind));
}

void command_perform(const struct illuminator_outbox *actions)
{
	for (uint32_t i = 0; i < actions->count; i++) {
		const struct illuminator_action *const action = &actions->actions[i];

		switch (action->kind) {
		case ILLUMINATOR_ACTION_LIGHT:
			strobe_timer_set(&action->light);
			break;
		case ILLUMINATOR_ACTION_NOTICE:
			notice(&action->notice);
			break;
		case ILLUMINATOR_ACTION_STATUS:
			break; /* protocols observe it */
		}
	}
	if (shown_revision != command.illuminator.revision) {
		shown_revision = command.illuminator.revision;
		show_settings();
		if (command.params.values[PARAM_LGT_RESTORE] != 0) {
			storage_save_light(&command.illuminator.settings);
		}
	}
	can_node_report(&command.illuminator);
	imc_node_report(&command.illuminator);
}

/* A step of the core on behalf of anyone but MAVLink. */
static enum illuminator_result step_core(const struct illuminator_event *event)
{
	const int64_t now_us = clock_now_us();
	struct illuminator_outbox actions;
	const enum illuminator_result result =
		illuminator_step(&command.illuminator, now_us, event, &actions);

	command_perform(&actions);
	mavlink_node_observe(&actions);
	return result;
}

enum arbiter_verdict command_apply(struct command *self, enum arbiter_source source,
                                   const struct illuminator_event *event,
                                   enum illuminator_result *result)
{
	const int64_t now_us = clock_now_us();
	const enum arbiter_verdict verdict = arbiter_check(&self->arbiter, now_us, source);

	if (verdict == ARBITER_GRANTED) {
		*result = step_core(event);
		if (*result == ILLUMINATOR_ACCEPTED) {
			arbiter_commit(&self->arbiter, now_us, source);
		}
	}
	return verdict;
}

/* Whether the illuminator would take all of them now. */
static bool would_accept(const struct illuminator_event *events, size_t count)
{
	struct illuminator trial = command.illuminator;
	struct illuminator_outbox ignored;
	bool accepted = true;

	for (size_t i = 0; i < count && accepted; i++) {
		accepted = illuminator_step(&trial, clock_now_us(), &events[i], &ignored) ==
		           ILLUMINATOR_ACCEPTED;
	}
	return accepted;
}

bool command_apply_all(struct command *self, enum arbiter_source source,
                       const struct illuminator_event *events, size_t count)
{
	bool applied = would_accept(events, count);

	for (size_t i = 0; i < count && applied; i++) {
		enum illuminator_result result;

		applied = command_apply(self, source, &events[i], &result) == ARBITER_GRANTED;
	}
	return applied;
}

/* --- parameters ------------------------------------------------------------------------------- */

static void configure_illuminator(void)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_CONFIG};

	params_illuminator(&command.params, &event.config);
	step_core(&event);
}

static void configure_thermal(void)
{
	struct thermal_config config;

	params_thermal(&command.params, &config);
	thermal_thread_configure(&config);
}

static void configure_sync(void)
{
	struct sync_config config;

	params_sync(&command.params, &config);
	strobe_timer_configure(&config);
}

static void configure_arbiter(void)
{
	struct arbiter_config config;

	params_arbiter(&command.params, &config);
	arbiter_configure(&command.arbiter, &config);
}

/* Ids are in force after a reset. */
void command_params_in_force(struct command *self, const struct param_set *changed)
{
	/* As after nearly every frame. */
	if (param_set_is_empty(changed)) {
		return;
	}
	if (param_set_touches(changed, PARAM_GROUP_LIGHT)) {
		configure_illuminator();
	}
	if (param_set_touches(changed, PARAM_GROUP_THERMAL)) {
		configure_thermal();
	}
	if (param_set_touches(changed, PARAM_GROUP_SYNC)) {
		configure_sync();
	}
	if (param_set_touches(changed, PARAM_GROUP_ARBITER)) {
		configure_arbiter();
	}
	if (param_set_touches(changed, PARAM_GROUP_MAVLINK)) {
		mavlink_node_configure(&self->params);
	}
	if (param_set_touches(changed, PARAM_GROUP_DRONECAN)) {
		can_node_configure(&self->params);
	}
	gimbal_node_configure(self, changed);
	actuation_configure(&self->params, changed);
	storage_save_params(&self->params, changed);
}

void command_params_changed(struct command *self, const struct param_set *changed)
{
	command_params_in_force(self, changed);
	mavlink_node_params_changed(changed);
}

enum params_result command_set_param(struct command *self, const char *name, size_t length,
                                     int32_t value)
{
	struct param_set changed;
	const enum params_result result =
		params_set_by_name(&self->params, name, length, value, &changed);

	command_params_changed(self, &changed);
	return result;
}

void command_reset_params(struct command *self)
{
	const struct param_set changed = params_reset(&self->params);

	command_params_changed(self, &changed);
}

/* --- start ------------------------------------------------------------------------------------ */

static void restore(const struct illuminator_settings *light)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_RESTORE,
	                                        .restore = *light};

	if (step_core(&event) != ILLUMINATOR_ACCEPTED) {
		LOG_WRN("the last settings do not fit; the lamp stays off");
	}
}

void command_init(void)
{
	struct illuminator_settings light;
	struct illuminator_config illuminator;
	struct thermal_config thermal;
	struct arbiter_config arbiter;
	struct sync_config sync;
	bool has_light;

	params_init(&command.params);
	startup_done(STARTUP_STORAGE, storage_load(&command.params, &light, &has_light));
	params_illuminator(&command.params, &illuminator);
	params_thermal(&command.params, &thermal);
	params_arbiter(&command.params, &arbiter);
	params_sync(&command.params, &sync);

	illuminator_init(&command.illuminator, &illuminator);
	arbiter_init(&command.arbiter, &arbiter);
	thermal_thread_init(&thermal);
	strobe_timer_init(&sync);
	self_test_init(&command.self_test);
	gimbal_node_init(&command);
	uart_links_init(&command.params);
	mavlink_node_init(&command);
	can_node_init(&command);
	imc_node_start(&command);
	show_settings();
	if (has_light && command.params.values[PARAM_LGT_RESTORE] != 0) {
		restore(&light);
	}
}

/* --- the queue -------------------------------------------------------------------------------- */

int command_post_frame(struct link_frame *frame)
{
	const struct item item = {.kind = ITEM_FRAME, .frame = frame};

	return k_msgq_put(&queue, &item, K_MSEC(SUPERVISOR_REPORT_MS));
}

int command_post_can(struct dronecan_frame *frame)
{
	const struct item item = {.kind = ITEM_CAN, .can = frame};

	return k_msgq_put(&queue, &item, K_MSEC(SUPERVISOR_REPORT_MS));
}

int command_post_imc(struct imc_frame *frame)
{
	const struct item item = {.kind = ITEM_IMC, .imc = frame};

	return k_msgq_put(&queue, &item, K_MSEC(SUPERVISOR_REPORT_MS));
}

/* With a full queue it is awake, and looks after the next item. */
void command_wake(void)
{
	const struct item item = {.kind = ITEM_WAKE};

	(void)k_msgq_put(&queue, &item, K_NO_WAIT);
}

void command_post_thermal(const struct thermal_report *report)
{
	const struct item item = {.kind = ITEM_THERMAL, .thermal = *report};

	if (k_msgq_put(&queue, &item, K_NO_WAIT) != 0) {
		stats.reports_dropped++;
	}
}

int command_call(int (*function)(struct command *, void *), void *argument)
{
	struct call call = {.function = function, .argument = argument};
	const struct item item = {.kind = ITEM_CALL, .call = &call};

	if (atomic_get(&running) == 0) {
		return -EAGAIN;
	}
	k_sem_init(&call.done, 0, 1);
	/* K_FOREVER: the supervisor watches who answers; a call cannot be taken back */
	k_msgq_put(&queue, &item, K_FOREVER);
	k_sem_take(&call.done, K_FOREVER); /* the same */
	return call.result;
}

struct command_stats command_stats_get(void)
{
	const unsigned int key = irq_lock();
	const struct command_stats copy = stats;

	irq_unlock(key);
	return copy;
}

static void take_thermal(const struct thermal_report *report)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_THERMAL,
	                                        .thermal = *report};

	stats.thermal_reports++;
	probe_set(devices.probe, PROBE_THERMAL_STATE, report->state);
	probe_set(devices.probe, PROBE_TEMPERATURE_MDEGC, report->temp_mdegc);
	step_core(&event);
}

static void take(const struct item *item)
{
	switch (item->kind) {
	case ITEM_FRAME:
		stats.frames++;
		mavlink_node_take(&command, item->frame->link, item->frame->bytes,
		                  item->frame->length);
		link_frame_free(item->frame);
		break;
	case ITEM_CAN:
		stats.can_frames++;
		can_node_take(&command, item->can);
		break;
	case ITEM_IMC:
		stats.imc_packets++;
		imc_node_take(&command, item->imc);
		break;
	case ITEM_THERMAL:
		take_thermal(&item->thermal);
		break;
	case ITEM_CALL:
		stats.calls++;
		item->call->result = item->call->function(&command, item->call->argument);
		k_sem_give(&item->call->done);
		break;
	case ITEM_WAKE:
		break;
	}
}

/* LGT_SRC_NOW, for whoever reads parameters. */
static void show_commander(void)
{
	params_tell(&command.params, PARAM_LGT_SRC_NOW, (int32_t)command.arbiter.commander);
}

/* What happens when every commander is silent. */
static void step_arbiter(void)
{
	const int64_t now_us = clock_now_us();

	if (arbiter_deadline_us(&command.arbiter) <= now_us &&
	    arbiter_advance(&command.arbiter, now_us)) {
		const struct illuminator_event event = {
			.kind = ILLUMINATOR_EVENT_FALLBACK,
			.fallback = command.arbiter.config.fallback,
		};

		step_core(&event);
	}
}

/* The sweep of a self-test, and what it finds. */
static void step_self_test(void)
{
	struct illuminator_event event;

	self_test_driver(&command.self_test, inputs_get().driver_fault);
	while (self_test_step(&command.self_test, clock_now_us(), &command.illuminator, &event)) {
		step_core(&event);
	}
}

static int64_t next_deadline_us(void)
{
	const int64_t core_us =
		MIN(arbiter_deadline_us(&command.arbiter), mavlink_node_deadline_us());
	const int64_t bus_us = MIN(can_node_deadline_us(), imc_node_due_us());
	const int64_t node_us = MIN(bus_us, gimbal_node_deadline_us(&command));
	const int64_t work_us = MIN(node_us, self_test_deadline_us(&command.self_test));

	return MIN(core_us, work_us);
}

static void step(void)
{
	step_arbiter();
	step_self_test();
	gimbal_node_step(&command);
	mavlink_node_step(&command);
	can_node_step(&command);
	imc_node_poll(&command);
}

void command_run(void *p1, void *p2, void *p3)
{
	int64_t deadline_us = next_deadline_us();

	atomic_set(&running, 1);
	for (;;) {
		const int64_t report_us = clock_now_us() + SUPERVISOR_REPORT_MS * US_PER_MS;
		const k_timeout_t wait = clock_timeout(MIN(deadline_us, report_us));
		struct item item = {.kind = ITEM_WAKE};

		if (k_msgq_get(&queue, &item, wait) == 0) {
			take(&item);
		}
		deadline_us = next_deadline_us();
		/* a frame changes nothing but what deadlines tell */
		if (item.kind != ITEM_FRAME || deadline_us <= clock_now_us()) {
			step();
			deadline_us = next_deadline_us();
		}
		show_commander();
		can_node_flush();
		supervisor_report(SUPERVISOR_COMMAND);
	}
}
