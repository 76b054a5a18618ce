/* SPDX-License-Identifier: Apache-2.0 */
#include "command_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/datagram.h>
#include <pharos/drivers/light.h>
#include <pharos/drivers/thermistor.h>

#include "check.h"
#include "core/light.h"
#include "core/store.h"
#include "proto/imc/codec.h"
#include "proto/mavlink/ftp.h"
#include "threads/can_link.h"
#include "threads/command.h"
#include "threads/devices.h"
#include "threads/firmware.h"
#include "threads/identity.h"
#include "threads/imc_link.h"
#include "threads/inputs.h"
#include "threads/outputs.h"
#include "threads/servos.h"
#include "threads/startup.h"
#include "threads/storage.h"
#include "threads/strobe.h"
#include "threads/thermal.h"
#include "threads/uart_link.h"

struct command_world world;
static jmp_buf end;

void command_world_init(const struct params *stored)
{
	memset(&world, 0, sizeof(world));
	world.stored = *stored;
}

void command_world_run(void)
{
	if (setjmp(end) == 0) {
		command_run(NULL, NULL, NULL);
	}
}

/* --- the kernel's ----------------------------------------------------------------------------- */

struct native_cpu native_cpu;

void native_irq_dispatch(void)
{
}

int64_t sys_clock_tick_get(void)
{
	return k_us_to_ticks_floor64((uint64_t)world.now_us);
}

void log_write(uint8_t level, const struct log_source *source, const char *fmt, ...)
{
}

void sys_reboot(int type)
{
	world.restarts = true;
	longjmp(end, 1);
}

ssize_t hwinfo_get_device_id(uint8_t *id, size_t length)
{
	memset(id, 7, length);
	return (ssize_t)length;
}

/* --- the board's ------------------------------------------------------------------------------ */

static int light_set(const struct device *dev, uint32_t ppm)
{
	return 0;
}

static void get_light(const struct device *dev, struct light_state *state)
{
	*state = (struct light_state){.error = world.driver_fault ? -EIO : 0};
}

static int off_now(const struct device *dev)
{
	return 0;
}

static int own_address(const struct device *dev, struct datagram_address *own)
{
	*own = (struct datagram_address){.ipv4 = 0x7F000001, .port = 6002};
	return 0;
}

static const struct light_driver_api light_api = {
	.set_level = light_set,
	.set_limit = light_set,
	.get = get_light,
	.off_now = off_now,
};
static const struct datagram_driver_api datagram_api = {.own = own_address};
static const struct device light = {.name = "light", .api = &light_api};
static const struct thermistor_driver_api thermistor_api = {0}; /* samples come as reports */
static const struct device thermistor = {.name = "thermistor", .api = &thermistor_api};
static const struct device datagrams = {.name = "datagrams", .api = &datagram_api};

const struct devices devices = {
	.light = &light, .thermistor = &thermistor, .imc_datagrams = &datagrams};

struct inputs_status inputs_get(void)
{
	return (struct inputs_status){.driver_fault = world.driver_fault};
}

void strobe_timer_init(const struct sync_config *sync)
{
}

void strobe_timer_configure(const struct sync_config *sync)
{
}

void strobe_timer_set(const struct light_plan *plan)
{
	CHECK(plan->level_ppm <= PPM_ONE);
	world.plan = *plan;
}

void thermal_thread_init(const struct thermal_config *config)
{
}

void thermal_thread_configure(const struct thermal_config *config)
{
	CHECK(config->throttle_mdegc < config->shutdown_mdegc);
}

bool servos_ready(void)
{
	return true;
}

void servos_move(struct pharos_device *device)
{
	for (int i = 0; i < GIMBAL_AXES; i++) {
		CHECK(device->gimbal.pulse_ns[i] >= 1000u * GIMBAL_PULSE_MIN_US &&
		      device->gimbal.pulse_ns[i] <= 1000u * GIMBAL_PULSE_MAX_US);
	}
}

void outputs_config(struct actuators_config *config)
{
	*config = (struct actuators_config){
		.power = 0x1F,
		.power_on = 0x03,
		.pwms = 0x07,
		.leds = 0x03,
		.gpio_outputs = 0x03,
		.gpio_inputs = 0x0C,
		.thruster = true,
		.focus = true,
		.display = true,
	};
}

void outputs_start(const struct actuators *actuators)
{
}

void outputs_perform(const struct actuators *actuators)
{
}

uint32_t outputs_read_inputs(const struct actuators *actuators)
{
	return 4;
}

/* --- start, supervision, identity ------------------------------------------------------------- */

void startup_done(enum startup_step step, int result)
{
}

int startup_result(enum startup_step step)
{
	return 0;
}

enum startup_step startup_failed(enum startup_step from)
{
	return STARTUP_STEPS;
}

bool startup_allows_light(void)
{
	return true;
}

const char *startup_name(enum startup_step step)
{
	return "";
}

void supervisor_report(enum supervisor_watch watch)
{
}

int32_t supervisor_age_ms(enum supervisor_watch watch)
{
	return 0;
}

const struct mavlink_identity *identity_get(void)
{
	static const uint8_t big[1000];
	static const struct mavlink_file served[] = {{"a", big, sizeof(big), 1}, {"b", big, 0, 2}};
	static const struct mavlink_files files = {served, 2};
	static const struct mavlink_identity identity = {
		.vendor_name = "a",
		.model_name = "b",
		.software_version = "1.0.0",
		.hardware_version = "1.0",
		.serial_number = "c",
		.files = &files,
	};

	return &identity;
}

void identity_boot_text(char text[IDENTITY_BOOT_TEXT_MAX])
{
	strcpy(text, "Pharos");
}

/* --- the store -------------------------------------------------------------------------------- */

int storage_load(struct params *params, struct illuminator_settings *settings, bool *has_light)
{
	*params = world.stored;
	*has_light = false;
	return 0;
}

void storage_save_params(const struct params *params, const struct param_set *changed)
{
	struct param_set set = *changed;

	for (uint32_t i; (i = param_set_take(&set)) != PARAM_COUNT;) {
		world.stored.values[i] = params->values[i];
	}
}

void storage_save_light(const struct illuminator_settings *settings)
{
}

uint8_t storage_load_power(uint8_t fallback)
{
	return fallback;
}

void storage_load_signing(struct mavlink_signing_record *signing)
{
	*signing = world.signing;
}

void storage_save_signing(const struct mavlink_signing_record *signing)
{
	world.signing = *signing;
}

struct storage_stats storage_stats_get(void)
{
	return (struct storage_stats){.failures = world.fails ? 1 : 0, .last_error = -EIO};
}

void firmware_begin(void (*done)(const char *failure))
{
	CHECK(!world.is_flashing);
	world.flashed = done;
	world.is_flashing = true;
	world.is_last = false;
}

void firmware_write(const uint8_t *data, size_t size, bool is_last)
{
	CHECK(world.flashed != NULL && !world.is_flashing && size <= 256);
	world.is_flashing = true;
	world.is_last = is_last;
}

void firmware_abort(const char *failure)
{
	CHECK(failure != NULL && !world.is_flashing);
	world.flashed = NULL;
}

bool firmware_is_busy(void)
{
	return world.flashed != NULL;
}

/* --- the inbox -------------------------------------------------------------------------------- */

void inbox_open(void)
{
}

struct inbox_item inbox_take(int64_t deadline_us)
{
	struct inbox_item item = {.kind = INBOX_WAKE};

	if (!command_next(deadline_us, &item)) {
		longjmp(end, 1);
	}
	return item;
}

void inbox_run(const struct inbox_item *item, struct pharos_device *device)
{
	command_call(device);
}

void inbox_done(const struct inbox_item *item)
{
}

/* --- links ------------------------------------------------------------------------------------ */

void uart_links_init(const struct params *params)
{
}

enum uart_protocol uart_link_protocol(uint8_t number)
{
	return number == UART_OF_IMC ? UART_PROTOCOL_IMC : UART_PROTOCOL_MAVLINK;
}

uint32_t uart_link_rate(uint8_t number)
{
	return 11520;
}

int uart_link_stats_get(uint8_t number, struct link_stats *stats)
{
	*stats = (struct link_stats){0};
	return 0;
}

int uart_link_send(uint8_t number, const uint8_t *frame, size_t length)
{
	CHECK(number < UART_LINKS_MAX && number != UART_OF_IMC);
	world.sent++;
	command_sent_mavlink(frame, length);
	return world.is_full ? -ENOBUFS : 0;
}

int uart_link_forward(uint8_t number, const uint8_t *frame, size_t length)
{
	CHECK(number < UART_LINKS_MAX && number != UART_OF_IMC && length <= MAVLINK_FRAME_MAX);
	world.sent++;
	return world.is_full ? -ENOBUFS : 0;
}

int can_link_init(uint32_t bitrate, bool fd)
{
	return 0;
}

bool can_link_has_fd(void)
{
	return false;
}

void can_link_listen(const struct can_link_filter *filters, size_t count)
{
	CHECK(count <= CAN_LINK_FILTERS_MAX);
}

bool can_link_send(const struct dronecan_frame *frame)
{
	CHECK(frame->size >= 1 && frame->size <= 8 && !frame->fd);
	CHECK(frame->id <= 0x1FFFFFFF);
	if (world.is_off_bus) {
		return false;
	}
	world.sent++;
	return true;
}

struct can_link_status can_link_status_get(void)
{
	return (struct can_link_status){0};
}

bool imc_link_has_datagrams(void)
{
	return true;
}

void imc_link_send(const struct imc_route *route, const uint8_t *bytes, size_t length)
{
	static struct imc_packet packet;

	CHECK(route->link == UART_OF_IMC || route->link == IMC_LINK_DATAGRAMS);
	CHECK(imc_decode(bytes, length, &packet) == IMC_OK);
	world.sent++;
}

void imc_link_announce(int32_t scope, const uint8_t *bytes, size_t length)
{
	static struct imc_packet packet;

	CHECK(imc_decode(bytes, length, &packet) == IMC_OK);
	world.sent++;
}
