/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/lights.h"

#include <string.h>

#include "core/assert.h"

/* The lamp that the ids are of. */
#define LAMP 0

#define REPORT_PERIOD_US (1 * US_PER_S)
#define PRIORITY_REPORT  24u
#define KELVIN_0_DEGC    273.15f

#define RED_BLUE_MAX 31u
#define GREEN_MAX    63u

#define PULSE_PLAUSIBLE_MIN_US 500.0f
#define PULSE_PLAUSIBLE_MAX_US 2500.0f
#define PULSE_CENTRE_US        1500.0f
#define PULSE_HALF_RANGE_US    500.0f

enum order_kind {
	ORDER_LAMP, /* on, and brightness_ppm, 0: as it is */
	ORDER_PAN,  /* position_ppm */
	ORDER_TILT,
};

/* Brightness by light, hardpoint or actuator, pan, tilt: a message commands each at most once. */
#define ORDERS_MAX 3u

struct order {
	enum order_kind kind;
	bool is_repeated; /* the same as this source's command before */
	bool on;
	uint32_t brightness_ppm;
	int32_t position_ppm; /* -PPM_ONE…PPM_ONE of the axis's range */
};

/* What a message says. */
struct orders {
	uint8_t count;
	struct order orders[ORDERS_MAX];
};

/* The next command counts as new, even if it is the same. */
static void forget(struct dronecan_lights *self)
{
	for (size_t i = 0; i < DRONECAN_LIGHTS_SOURCES; i++) {
		self->last[i] = INT32_MIN;
	}
}

void dronecan_lights_init(struct dronecan_lights *self, int64_t now_us,
                          const struct dronecan_lights_config *config, struct pharos_device *device)
{
	memset(self, 0, sizeof(*self));
	self->device = device;
	self->config = *config;
	self->report_us = now_us;
	forget(self);
}

void dronecan_lights_configure(struct dronecan_lights *self,
                               const struct dronecan_lights_config *config)
{
	self->config = *config;
	forget(self);
}

/* --- carrying out ----------------------------------------------------------------------------- */

static enum device_result light(struct dronecan_lights *self, int64_t now_us,
                                const struct device_who *who, const struct order *order)
{
	const struct illuminator_event events[] = {
		{.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = order->on},
		{.kind = ILLUMINATOR_EVENT_BRIGHTNESS, .brightness_ppm = order->brightness_ppm},
	};

	return pharos_device_apply(self->device, now_us, who, LAMP, events,
	                           order->brightness_ppm == 0 ? 1 : 2);
}

static enum device_result point(struct dronecan_lights *self, int64_t now_us,
                                const struct device_who *who, const struct order *order)
{
	const enum gimbal_axis_id axis = order->kind == ORDER_PAN ? GIMBAL_PAN : GIMBAL_TILT;
	struct gimbal_event aim = {.kind = GIMBAL_EVENT_AIM};

	if (!pharos_device_has_gimbal(self->device)) {
		return DEVICE_ABSENT;
	}
	aim.aim[axis] = (struct gimbal_aim){
		.kind = GIMBAL_ANGLE,
		.value = pharos_device_share_mdeg(self->device, axis, order->position_ppm),
	};
	return pharos_device_point(self->device, now_us, who, &aim);
}

static enum device_result give(struct dronecan_lights *self, int64_t now_us,
                               const struct order *order)
{
	const struct device_who who = {
		.way = SECURITY_WAY_DRONECAN,
		.is_repeated = order->is_repeated,
	};

	return order->kind == ORDER_LAMP ? light(self, now_us, &who, order)
	                                 : point(self, now_us, &who, order);
}

static void carry_out(struct dronecan_lights *self, int64_t now_us, const struct orders *orders)
{
	for (uint8_t i = 0; i < orders->count; i++) {
		switch (give(self, now_us, &orders->orders[i])) {
		case DEVICE_ACCEPTED:
			self->stats.applied++;
			break;
		case DEVICE_KEPT:
			self->stats.kept++;
			break;
		case DEVICE_ABSENT:
			self->stats.no_gimbal++;
			break;
		case DEVICE_DENIED:
		case DEVICE_FAILED:
		case DEVICE_EXCLUDED:
		case DEVICE_OUTRANKED:
			self->stats.rejected++;
			forget(self);
			break;
		}
	}
}

/* --- reading ---------------------------------------------------------------------------------- */

/* The place for this kind of order: the last command of a message holds. */
static struct order *place(struct orders *orders, enum order_kind kind)
{
	for (uint8_t i = 0; i < orders->count; i++) {
		if (orders->orders[i].kind == kind) {
			return &orders->orders[i];
		}
	}
	PHAROS_ASSERT(orders->count < ORDERS_MAX);
	orders->orders[orders->count].kind = kind;
	return &orders->orders[orders->count++];
}

/* value: what decides whether the command is the same as the one before. */
static struct order *command(struct dronecan_lights *self, enum dronecan_lights_source source,
                             int32_t value, enum order_kind kind, struct orders *orders)
{
	const uint8_t before = orders->count;
	struct order *const order = place(orders, kind);
	const bool is_fresh = orders->count > before;

	self->stats.commands++;
	order->is_repeated = self->last[source] == value && (is_fresh || order->is_repeated);
	self->last[source] = value;
	return order;
}

/* Dark is off and keeps the brightness set before. */
static void command_brightness(struct order *order, uint32_t brightness_ppm)
{
	order->on = brightness_ppm > 0;
	order->brightness_ppm = brightness_ppm;
}

static uint32_t ratio_ppm(uint32_t value, uint32_t max)
{
	return (value * PPM_ONE + max / 2u) / max;
}

static uint32_t max_of(uint32_t a, uint32_t b)
{
	return (a > b) ? a : b;
}

static void receive_lights(struct dronecan_lights *self, const struct dronecan_transfer *transfer,
                           struct orders *orders)
{
	struct dronecan_indication_lights_command message;

	if (!dronecan_indication_lights_command_decode(&message, !transfer->fd, transfer->data,
	                                               transfer->size)) {
		self->stats.malformed++;
		return;
	}
	for (uint8_t i = 0; i < message.commands_len; i++) {
		const struct dronecan_indication_rgb565 *color = &message.commands[i].color;

		if (message.commands[i].light_id != self->config.light_id) {
			continue;
		}
		const uint32_t level_ppm =
			max_of(ratio_ppm(max_of(color->red, color->blue), RED_BLUE_MAX),
		               ratio_ppm(color->green, GREEN_MAX));

		command_brightness(command(self, DRONECAN_LIGHTS_SOURCE_LIGHT, (int32_t)level_ppm,
		                           ORDER_LAMP, orders),
		                   level_ppm);
	}
}

static void receive_hardpoint(struct dronecan_lights *self,
                              const struct dronecan_transfer *transfer, struct orders *orders)
{
	struct dronecan_hardpoint_command message;

	if (!dronecan_hardpoint_command_decode(&message, !transfer->fd, transfer->data,
	                                       transfer->size)) {
		self->stats.malformed++;
		return;
	}
	if (message.hardpoint_id == self->config.hardpoint_id) {
		const bool on = message.command != 0;
		struct order *const order = command(self, DRONECAN_LIGHTS_SOURCE_HARDPOINT,
		                                    on ? 1 : 0, ORDER_LAMP, orders);

		order->on = on;
		order->brightness_ppm = 0;
	}
}

/* -PPM_ONE…PPM_ONE. False: no meaning here; comparisons with NaN are false. */
static bool position(const struct dronecan_actuator_command *message, int32_t *position_ppm)
{
	float value = message->command_value;

	if (message->command_type == DRONECAN_ACTUATOR_COMMAND_COMMAND_TYPE_PWM) {
		if (!(value >= PULSE_PLAUSIBLE_MIN_US && value <= PULSE_PLAUSIBLE_MAX_US)) {
			return false;
		}
		value = (value - PULSE_CENTRE_US) / PULSE_HALF_RANGE_US;
	} else if (message->command_type != DRONECAN_ACTUATOR_COMMAND_COMMAND_TYPE_UNITLESS ||
	           !(value >= -65504.0f && value <= 65504.0f)) {
		return false;
	}
	if (value > 1.0f) {
		value = 1.0f;
	} else if (value < -1.0f) {
		value = -1.0f;
	}
	*position_ppm = (int32_t)(value * (float)PPM_ONE);
	return true;
}

static void actuate(struct dronecan_lights *self, const struct dronecan_actuator_command *message,
                    struct orders *orders)
{
	const int16_t id = message->actuator_id;
	int32_t position_ppm;

	if (id != self->config.brightness_actuator_id && id != self->config.pan_actuator_id &&
	    id != self->config.tilt_actuator_id) {
		return;
	}
	if (!position(message, &position_ppm)) {
		self->stats.refused++;
		return;
	}
	if (id == self->config.brightness_actuator_id) {
		command_brightness(command(self, DRONECAN_LIGHTS_SOURCE_BRIGHTNESS, position_ppm,
		                           ORDER_LAMP, orders),
		                   (uint32_t)(position_ppm + (int32_t)PPM_ONE) / 2u);
	}
	if (id == self->config.pan_actuator_id) {
		command(self, DRONECAN_LIGHTS_SOURCE_PAN, position_ppm, ORDER_PAN, orders)
			->position_ppm = position_ppm;
	}
	if (id == self->config.tilt_actuator_id) {
		command(self, DRONECAN_LIGHTS_SOURCE_TILT, position_ppm, ORDER_TILT, orders)
			->position_ppm = position_ppm;
	}
}

static void receive_actuators(struct dronecan_lights *self,
                              const struct dronecan_transfer *transfer, struct orders *orders)
{
	struct dronecan_actuator_array_command message;

	if (!dronecan_actuator_array_command_decode(&message, !transfer->fd, transfer->data,
	                                            transfer->size)) {
		self->stats.malformed++;
		return;
	}
	for (uint8_t i = 0; i < message.commands_len; i++) {
		actuate(self, &message.commands[i], orders);
	}
}

void dronecan_lights_receive(struct dronecan_lights *self, int64_t now_us,
                             const struct dronecan_transfer *transfer)
{
	struct orders orders = {.count = 0};

	if (transfer->kind != DRONECAN_MESSAGE || transfer->source == 0) {
		return;
	}
	if (transfer->type == &dronecan_indication_lights_command_type) {
		receive_lights(self, transfer, &orders);
	} else if (transfer->type == &dronecan_hardpoint_command_type) {
		receive_hardpoint(self, transfer, &orders);
	} else if (transfer->type == &dronecan_actuator_array_command_type) {
		receive_actuators(self, transfer, &orders);
	}
	carry_out(self, now_us, &orders);
}

/* --- telling ---------------------------------------------------------------------------------- */

void dronecan_lights_set_report(struct dronecan_lights *self, int64_t now_us,
                                const struct dronecan_lights_report *report)
{
	if (report->on != self->report.on) {
		self->report_us = now_us;
	}
	self->report = *report;
}

static void send(int64_t now_us, struct dronecan_transport *transport,
                 const struct dronecan_type *type, const uint8_t *data, size_t size)
{
	const struct dronecan_transfer transfer = {
		.type = type,
		.kind = DRONECAN_MESSAGE,
		.priority = PRIORITY_REPORT,
		.fd = true,
		.data = data,
		.size = size,
	};

	/* No room: counted there, and the next one is a second away. */
	(void)dronecan_transport_send(transport, now_us, &transfer);
}

static void send_hardpoint_status(const struct dronecan_lights *self, int64_t now_us,
                                  struct dronecan_transport *transport)
{
	const struct dronecan_hardpoint_status message = {
		.hardpoint_id = (uint8_t)self->config.hardpoint_id,
		.status = self->report.on ? 1 : 0,
	};
	uint8_t data[DRONECAN_HARDPOINT_STATUS_MAX_SIZE];
	size_t size;

	if (dronecan_hardpoint_status_encode(&message, false, data, sizeof(data), &size)) {
		send(now_us, transport, &dronecan_hardpoint_status_type, data, size);
	}
}

static void send_temperature(const struct dronecan_lights *self, int64_t now_us,
                             struct dronecan_transport *transport)
{
	const struct dronecan_device_temperature message = {
		.device_id = (self->config.light_id >= 0) ? (uint16_t)self->config.light_id : 0,
		.temperature = (float)self->report.temp_mdegc / 1000.0f + KELVIN_0_DEGC,
		.error_flags = self->report.overheating
	                               ? DRONECAN_DEVICE_TEMPERATURE_ERROR_FLAG_OVERHEATING
	                               : 0,
	};
	uint8_t data[DRONECAN_DEVICE_TEMPERATURE_MAX_SIZE];
	size_t size;

	if (dronecan_device_temperature_encode(&message, false, data, sizeof(data), &size)) {
		send(now_us, transport, &dronecan_device_temperature_type, data, size);
	}
}

void dronecan_lights_step(struct dronecan_lights *self, int64_t now_us,
                          struct dronecan_transport *transport)
{
	if (now_us < self->report_us) {
		return;
	}
	self->report_us += REPORT_PERIOD_US;
	if (self->report_us <= now_us) {
		self->report_us = now_us + REPORT_PERIOD_US;
	}
	if (transport->node_id == 0) {
		return;
	}
	if (self->config.hardpoint_id != DRONECAN_LIGHTS_ID_NONE) {
		send_hardpoint_status(self, now_us, transport);
	}
	if (self->report.temp_valid) {
		send_temperature(self, now_us, transport);
	}
}

int64_t dronecan_lights_deadline_us(const struct dronecan_lights *self)
{
	return self->report_us;
}
