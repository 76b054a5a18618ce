/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/command.h"

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>

#include <pharos/drivers/probe.h>

#include "threads/can_node.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/frames.h"
#include "threads/imc_light.h"
#include "threads/inbox.h"
#include "threads/inputs.h"
#include "threads/mavlink_node.h"
#include "threads/outputs.h"
#include "threads/servos.h"
#include "threads/startup.h"
#include "threads/storage.h"
#include "threads/strobe.h"
#include "threads/supervisor.h"
#include "threads/thermal.h"
#include "threads/tunnel_link.h"
#include "threads/uart_link.h"

LOG_MODULE_REGISTER(command);

/* The lamp that this board has. */
#define LAMP 0

_Static_assert(DEVICE_LAMPS_MAX == 1, "the effects of one lamp are performed");

static struct pharos_device device;

/* --- performing what the device wants done ---------------------------------------------------- */

static void show_settings(const struct illuminator_settings *now)
{
	probe_set(devices.probe, PROBE_ENABLE, now->enable);
	probe_set(devices.probe, PROBE_MODE, now->mode);
	probe_set(devices.probe, PROBE_BRIGHTNESS_PPM, now->brightness_ppm);
	probe_set(devices.probe, PROBE_STROBE_PERIOD_US, now->strobe_period_us);
	probe_set(devices.probe, PROBE_STROBE_DUTY_PPM, now->duty_ppm);
}

static void notice(const struct illuminator *light, enum illuminator_notice_kind kind)
{
	if (kind == ILLUMINATOR_NOTICE_SENSOR_FAILED) {
		LOG_WRN("%s: %s", illuminator_notice_text(kind),
		        thermal_fault_name(light->thermal.fault));
	} else {
		LOG_WRN("%s", illuminator_notice_text(kind));
	}
}

static void perform_lamp(const struct device_effects *effects)
{
	const struct illuminator *const light = &device.lamps[LAMP].illuminator;

	if (effects->lights != 0) {
		strobe_timer_set(&light->plan);
	}
	for (uint32_t kind = 0; effects->notices[LAMP] >> kind != 0; kind++) {
		if ((effects->notices[LAMP] & BIT(kind)) != 0) {
			notice(light, (enum illuminator_notice_kind)kind);
		}
	}
	if (effects->settings != 0) {
		show_settings(&light->settings);
		if (device.params.values[PARAM_LGT_RESTORE] != 0) {
			storage_save_light(&light->settings);
		}
	}
}

static void perform_params(const struct param_set *changed)
{
	struct thermal_config thermal;
	struct sync_config sync;

	if (param_set_is_empty(changed)) {
		return;
	}
	if (param_set_touches(changed, PARAM_GROUP_THERMAL)) {
		params_thermal(&device.params, &thermal);
		thermal_thread_configure(&thermal);
	}
	if (param_set_touches(changed, PARAM_GROUP_SYNC)) {
		params_sync(&device.params, &sync);
		strobe_timer_configure(&sync);
	}
	storage_save_params(&device.params, changed);
}

static void perform(const struct device_effects *effects)
{
	perform_lamp(effects);
	if (effects->move) {
		servos_move(&device);
	}
#ifdef CONFIG_PHAROS_IMC
	if (effects->outputs) {
		outputs_perform(&device.actuators);
	}
#endif
	perform_params(&effects->params);
}

/* What the device wants is in force, and all know, before an answer says so. */
static void settle(void)
{
	struct device_effects effects;

	while (pharos_device_take(&device, &effects)) {
		perform(&effects);
		mavlink_node_tell(&effects);
		can_node_tell(&effects);
		imc_light_tell(&effects);
	}
	mavlink_node_flush();
	imc_light_flush();
}

/* --- start ------------------------------------------------------------------------------------ */

static void init_outside(const struct params *params)
{
	struct thermal_config thermal;
	struct sync_config sync;

	params_thermal(params, &thermal);
	params_sync(params, &sync);
	thermal_thread_init(&thermal);
	strobe_timer_init(&sync);
}

static void init_device(void)
{
	struct device_config config = {.gimbal = servos_ready()};

#ifdef CONFIG_PHAROS_IMC
	outputs_config(&config.actuators);
#endif
	pharos_device_init(&device, clock_now_us(), &config);
#ifdef CONFIG_PHAROS_IMC
	outputs_start(&device.actuators);
#endif
}

static void restore(const struct illuminator_settings *light)
{
	if (pharos_device_restore(&device, clock_now_us(), LAMP, light) != DEVICE_ACCEPTED) {
		LOG_WRN("the last settings do not fit; the lamp stays off");
	}
	settle();
}

void command_init(void)
{
	struct illuminator_settings light;
	bool has_light;

	params_init(&device.params);
	startup_done(STARTUP_STORAGE, storage_load(&device.params, &light, &has_light));
	init_outside(&device.params);
	init_device();
	uart_links_init(&device.params);
	mavlink_node_init(&device);
	can_node_init(&device);
	imc_light_init(&device);
	show_settings(&device.lamps[LAMP].illuminator.settings);
	if (has_light && device.params.values[PARAM_LGT_RESTORE] != 0) {
		restore(&light);
	}
}

/* --- the loop --------------------------------------------------------------------------------- */

static void take_mavlink(uint8_t link, const uint8_t *bytes, size_t length)
{
	mavlink_node_take(link, bytes, length);
	settle();
}

static void take_tunnels(void)
{
	struct tunnel_event event;

	while (tunnel_links_next(&event)) {
		switch (event.kind) {
		case TUNNEL_UP:
			mavlink_node_link_up(event.link);
			break;
		case TUNNEL_DOWN:
			mavlink_node_link_down(event.link);
			break;
		case TUNNEL_FRAME:
			take_mavlink(event.link, event.frame.bytes, event.frame.length);
			break;
		}
	}
}

static void take_thermal(const struct thermal_report *report)
{
	probe_set(devices.probe, PROBE_THERMAL_STATE, report->state);
	probe_set(devices.probe, PROBE_TEMPERATURE_MDEGC, report->temp_mdegc);
	pharos_device_report_heat(&device, clock_now_us(), LAMP, report);
}

static void take(const struct inbox_item *item)
{
	switch (item->kind) {
	case INBOX_FRAME:
		mavlink_node_take(item->frame->link, item->frame->bytes, item->frame->length);
		break;
	case INBOX_CAN:
		can_node_take(item->can);
		break;
	case INBOX_IMC:
		imc_light_take(item->imc);
		break;
	case INBOX_THERMAL:
		take_thermal(&item->thermal);
		break;
	case INBOX_CALL:
		inbox_run(item, &device);
		break;
	case INBOX_WAKE:
		break;
	}
	settle();
	if (item->kind == INBOX_CAN) {
		take_tunnels();
	}
	inbox_done(item);
}

/* Until the watchdog bites a thermal thread that stalls, its last report would be told as true. */
static void step_heat(void)
{
	const struct thermal_report *const last = &device.lamps[LAMP].illuminator.thermal;
	const struct thermal_report unknown = {
		.state = last->state,
		.sensor = THERMAL_SENSOR_FAILED,
		.fault = THERMAL_FAULT_MISSING,
		.flags = last->flags | THERMAL_FLAG_THERMISTOR,
		.dark = true,
	};

	if (supervisor_age_ms(SUPERVISOR_THERMAL) > SUPERVISOR_LIMIT_MS &&
	    !(last->dark && last->fault == THERMAL_FAULT_MISSING)) {
		take_thermal(&unknown);
	}
}

static int64_t next_deadline_us(void)
{
	const int64_t all_us[] = {
		pharos_device_deadline_us(&device),
		mavlink_node_deadline_us(),
		can_node_deadline_us(),
		tunnel_links_deadline_us(),
		imc_light_deadline_us(),
	};
	int64_t first_us = TIME_NEVER_US;

	for (size_t i = 0; i < ARRAY_SIZE(all_us); i++) {
		first_us = MIN(first_us, all_us[i]);
	}
	return first_us;
}

static void step(void)
{
	step_heat();
	pharos_device_report_driver(&device, LAMP, inputs_get().driver_fault);
	pharos_device_step(&device, clock_now_us());
	settle();
	mavlink_node_warn();
	while (mavlink_node_deadline_us() <= clock_now_us()) {
		mavlink_node_step();
		settle();
	}
	can_node_step();
	settle();
	tunnel_links_step();
	take_tunnels();
	imc_light_step();
	settle();
}

void command_run(void *p1, void *p2, void *p3)
{
	int64_t deadline_us = next_deadline_us();

	inbox_open();
	for (;;) {
		const int64_t report_us = clock_now_us() + SUPERVISOR_REPORT_MS * US_PER_MS;
		const struct inbox_item item = inbox_take(MIN(deadline_us, report_us));

		take(&item);
		/* a frame changes nothing but what deadlines tell */
		deadline_us = item.kind == INBOX_FRAME ? next_deadline_us() : clock_now_us();
		if (deadline_us <= clock_now_us()) {
			step();
			deadline_us = next_deadline_us();
		}
		can_node_flush();
		supervisor_report(SUPERVISOR_COMMAND);
	}
}
