/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/illuminator_service.h"

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"
#include "proto/mavlink/real.h"

#include <stddef.h>
#include <string.h>

#define STREAM_INTERVAL_US 1000000

#define PPM_PER_PERCENT 10000.0f
#define MICRO           1000000.0f
#define MILLI           1000.0f

_Static_assert((int)ILLUMINATOR_MODE_INTERNAL == (int)ILLUMINATOR_MODE_INTERNAL_CONTROL, "wire");
_Static_assert((int)ILLUMINATOR_MODE_SYNC == (int)ILLUMINATOR_MODE_EXTERNAL_SYNC, "wire");

void mavlink_illuminator_init(struct mavlink_illuminator *self, struct pharos_device *device,
                              uint8_t lamp, const struct mavlink_identity *identity)
{
	memset(self, 0, sizeof(*self));
	self->device = device;
	self->lamp = lamp;
	self->identity = identity;
	mavlink_params_init(&self->params, device, MAVLINK_PARAMS_LIGHT);
	mavlink_self_test_init(&self->self_test, device, lamp);
#ifdef CONFIG_PHAROS_FTP
	mavlink_ftp_init(&self->ftp, identity->files, &self->params);
#endif
	for (size_t i = 0; i < MAVLINK_NOTICE_KINDS; i++) {
		self->noticed_us[i] = -1;
	}
}

static const struct illuminator *light_of(const struct mavlink_illuminator *self)
{
	return &pharos_device_lamp(self->device, self->lamp)->illuminator;
}

/* --- commands -------------------------------------------------------------------------------- */

static uint8_t apply(const struct mavlink_context *context, const struct illuminator_event *event)
{
	const struct mavlink_illuminator *const self = context->component->service;
	const struct device_who who = mavlink_who(context);

	return mavlink_result(
		pharos_device_apply(self->device, context->now_us, &who, self->lamp, event, 1));
}

/* 405: param1 is 0 or 1. param2, soon an illuminator's id, is tolerated. */
static uint8_t on_off(const struct mavlink_context *context, const struct mavlink_command *command,
                      struct mavlink_reply *reply)
{
	uint32_t enable;

	(void)reply;
	if (!mavlink_whole(command->param[0], 1, &enable)) {
		return MAV_RESULT_DENIED;
	}

	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_ON_OFF,
		.on_off = enable != 0,
	};

	return apply(context, &event);
}

/* Half up. A percentage above 0 may round to 0 as brightness, but never as duty: see duty_of. */
static bool percent_of(float wire, struct mavlink_echo *echo)
{
	if (!(wire >= 0.0f && wire <= 100.0f)) {
		return false;
	}
	echo->wire = wire;
	echo->core = (uint32_t)(wire * PPM_PER_PERCENT + 0.5f);
	return true;
}

/* A duty of 0 means no strobe, that is: always lit. So the smallest duty must not become 0. */
static bool duty_of(float wire, struct mavlink_echo *echo)
{
	if (!percent_of(wire, echo)) {
		return false;
	}
	if (wire > 0.0f && echo->core == 0) {
		echo->core = 1;
	}
	return true;
}

static float seconds(uint32_t us)
{
	return (float)us / MICRO;
}

/* Compares with the very floats that ILLUMINATOR_STATUS reports as the limits. */
static bool period_of(float wire, const struct illuminator_config *config,
                      struct mavlink_echo *echo)
{
	const float min_s = seconds(config->min_period_us);
	const float max_s = seconds(config->max_period_us);

	echo->wire = wire;
	echo->core = 0;
	if (wire == 0.0f) {
		return true;
	}
	if (!(wire >= min_s && wire <= max_s)) {
		return false;
	}

	const uint32_t whole = (uint32_t)wire;
	const float rest = wire - (float)whole;
	const uint64_t us = (uint64_t)whole * US_PER_S + (uint32_t)(rest * MICRO + 0.5f);

	/* The floats of the limits may have been rounded outwards. */
	echo->core = (uint32_t)(us < config->min_period_us   ? config->min_period_us
	                        : us > config->max_period_us ? config->max_period_us
	                                                     : us);
	return true;
}

/*
 * 406: mode, brightness, period, duty. param5, soon an illuminator's id, is tolerated. The core
 * knows which modes there are.
 */
static uint8_t configure(const struct mavlink_context *context,
                         const struct mavlink_command *command, struct mavlink_reply *reply)
{
	struct mavlink_illuminator *const self = context->component->service;
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_CONFIGURE};
	struct mavlink_echo brightness;
	struct mavlink_echo period;
	struct mavlink_echo duty;

	(void)reply;
	if (!mavlink_whole(command->param[0], UINT8_MAX, &event.configure.mode) ||
	    !percent_of(command->param[1], &brightness) ||
	    !period_of(command->param[2], &light_of(self)->config, &period) ||
	    !duty_of(command->param[3], &duty)) {
		return MAV_RESULT_DENIED;
	}
	event.configure.brightness_ppm = brightness.core;
	event.configure.strobe_period_us = period.core;
	event.configure.duty_ppm = duty.core;

	const uint8_t result = apply(context, &event);

	if (result == MAV_RESULT_ACCEPTED) {
		self->brightness = brightness;
		self->period = period;
		self->duty = duty;
	}
	return result;
}

static const struct mavlink_command_row commands[] = {
	MAVLINK_COMMON_COMMANDS,
	{.id = MAV_CMD_ILLUMINATOR_ON_OFF, .run = on_off},
	{.id = MAV_CMD_DO_ILLUMINATOR_CONFIGURE, .run = configure},
	{.id = MAV_CMD_USER_1,
         .run = mavlink_self_test_run,
         .cancel = mavlink_self_test_cancel,
         .knows = mavlink_self_test_knows},
	{.id = MAV_CMD_PREFLIGHT_STORAGE, .run = mavlink_preflight_storage},
	{.id = MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, .run = mavlink_preflight_reboot},
};

/* --- messages -------------------------------------------------------------------------------- */

/* As it was commanded, unless the core holds something else by now. */
static float echoed(const struct mavlink_echo *echo, uint32_t core, float converted)
{
	return echo->core == core ? echo->wire : converted;
}

static uint8_t fill_status(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_illuminator *const self = context->component->service;
	const struct illuminator *const light = light_of(self);
	const struct illuminator_settings *const settings = &light->settings;
	mavlink_illuminator_status_t *const status = payload;

	(void)argument;
	status->uptime_ms = (uint32_t)(context->now_us / US_PER_MS);
	status->enable = settings->enable ? 1 : 0;
	status->mode_bitmask = ILLUMINATOR_MODES_SUPPORTED;
	status->mode = (uint8_t)settings->mode;
	status->error_status = illuminator_error_flags(light);
	status->brightness = echoed(&self->brightness, settings->brightness_ppm,
	                            (float)settings->brightness_ppm / PPM_PER_PERCENT);
	status->strobe_period = echoed(&self->period, settings->strobe_period_us,
	                               seconds(settings->strobe_period_us));
	status->strobe_duty_cycle = echoed(&self->duty, settings->duty_ppm,
	                                   (float)settings->duty_ppm / PPM_PER_PERCENT);
	status->temp_c = light->thermal.temp_valid ? (float)light->thermal.temp_mdegc / MILLI : NAN;
	status->min_strobe_period = seconds(light->config.min_period_us);
	status->max_strobe_period = seconds(light->config.max_period_us);
	return MAV_RESULT_ACCEPTED;
}

#ifdef CONFIG_PHAROS_FTP
static uint8_t fill_metadata(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_illuminator *const self = context->component->service;

	(void)argument;
	mavlink_fill_metadata(&self->identity->files->files[0], context->now_us, payload);
	return MAV_RESULT_ACCEPTED;
}

static void file_transfer(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	struct mavlink_illuminator *const self = context->component->service;

	mavlink_ftp_receive(&self->ftp, context, frame);
}
#endif

static const struct mavlink_message_row messages[] = {
	MAVLINK_HEARTBEAT(STREAM_INTERVAL_US),
	{.kind = MAVLINK_KIND(ILLUMINATOR_STATUS),
         .interval_us = STREAM_INTERVAL_US,
         .flags = MAVLINK_MESSAGE_ON_CHANGE,
         .fill = fill_status},
#ifdef CONFIG_PHAROS_FTP
	{.kind = MAVLINK_KIND(COMPONENT_METADATA),
         .interval_us = MAVLINK_INTERVAL_OFF,
         .fill = fill_metadata},
#endif
	MAVLINK_COMMON_MESSAGES,
};

/* --- what others did and who is there ----------------------------------------------------------
 */

static uint8_t severity_of(enum illuminator_notice_kind kind)
{
	switch (kind) {
	case ILLUMINATOR_NOTICE_THROTTLING_BEGINS:
		return MAV_SEVERITY_WARNING;
	case ILLUMINATOR_NOTICE_THROTTLING_ENDS:
		return MAV_SEVERITY_INFO;
	case ILLUMINATOR_NOTICE_SHUTDOWN:
		return MAV_SEVERITY_CRITICAL;
	case ILLUMINATOR_NOTICE_RECOVERED:
		return MAV_SEVERITY_NOTICE;
	case ILLUMINATOR_NOTICE_SENSOR_FAILED:
		return MAV_SEVERITY_ERROR;
	case ILLUMINATOR_NOTICE_SENSOR_OK:
		return MAV_SEVERITY_NOTICE;
	}
	return MAV_SEVERITY_DEBUG;
}

_Static_assert(ILLUMINATOR_NOTICE_SENSOR_OK + 1 == MAVLINK_NOTICE_KINDS, "a time for each kind");

static void append(char *text, size_t *length, const char *more)
{
	for (; *more != '\0' && *length + 1 < MAVLINK_TEXT_BYTES; more++) {
		text[(*length)++] = *more;
	}
	text[*length] = '\0';
}

/* The same notice again within MAVLINK_NOTICE_GAP_US is not news. */
static void notice(const struct mavlink_context *context, enum illuminator_notice_kind kind)
{
	struct mavlink_illuminator *const self = context->component->service;
	int64_t *const noticed_us = &self->noticed_us[kind];
	char text[MAVLINK_TEXT_BYTES];
	size_t length = 0;

	if (*noticed_us >= 0 && context->now_us - *noticed_us < MAVLINK_NOTICE_GAP_US) {
		context->endpoint->texts.dropped++;
		return;
	}
	append(text, &length, illuminator_notice_text(kind));
	if (kind == ILLUMINATOR_NOTICE_SENSOR_FAILED) {
		append(text, &length, ": ");
		append(text, &length, thermal_fault_name(light_of(self)->thermal.fault));
	}
	if (mavlink_endpoint_text(context->endpoint, context->now_us, severity_of(kind), text)) {
		*noticed_us = context->now_us;
	}
}

/* What the device did becomes news for clients and words for people. */
static void tell(const struct mavlink_context *context, const struct device_effects *effects)
{
	struct mavlink_illuminator *const self = context->component->service;
	const uint32_t notices = effects->notices[self->lamp];

	if ((effects->statuses & 1u << self->lamp) != 0) {
		mavlink_changed(context);
	}
	for (uint32_t kind = 0; kind < MAVLINK_NOTICE_KINDS; kind++) {
		if ((notices & 1u << kind) != 0) {
			notice(context, (enum illuminator_notice_kind)kind);
		}
	}
	mavlink_params_tell(&self->params, context, &effects->params);
}

/*
 * Ground stations and autopilots command lights; other peripherals' heartbeats say nothing, nor do
 * relays', which go on when whoever spoke through them has gone.
 */
static void heartbeat(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	const struct mavlink_illuminator *const self = context->component->service;
	mavlink_heartbeat_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));

	const struct mavlink_vehicle_heartbeat said = {
		.system = frame->system_id,
		.component = frame->component_id,
		.type = wire.type,
		.autopilot = wire.autopilot,
	};

	const struct device_who who = mavlink_who(context);

	if (!pharos_device_may(self->device, &who, SECURITY_EXIST)) {
		return;
	}
	mavlink_vehicle_heard(&context->endpoint->vehicle, context->now_us, &said);
	if (!mavlink_is_relay(frame) &&
	    (wire.type == MAV_TYPE_GCS || wire.autopilot != MAV_AUTOPILOT_INVALID)) {
		pharos_device_heard(self->device, context->now_us, &who);
	}
}

static const struct mavlink_receiver_row receivers[] = {
	MAVLINK_COMMON_RECEIVERS,
	{.id = MAVLINK_MSG_ID_COMMAND_CANCEL,
         .target_system_offset = offsetof(mavlink_command_cancel_t, target_system),
         .target_component_offset = offsetof(mavlink_command_cancel_t, target_component),
         .receive = mavlink_command_cancel},
	{.id = MAVLINK_MSG_ID_HEARTBEAT,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = heartbeat},
	{.id = MAVLINK_MSG_ID_PING,
         .target_system_offset = offsetof(mavlink_ping_t, target_system),
         .target_component_offset = offsetof(mavlink_ping_t, target_component),
         .receive = mavlink_ping},
	{.id = MAVLINK_MSG_ID_TIMESYNC,
         .target_system_offset = MAVLINK_TIMESYNC_TARGET_SYSTEM,
         .target_component_offset = MAVLINK_TIMESYNC_TARGET_COMPONENT,
         .receive = mavlink_timesync},
#ifdef CONFIG_PHAROS_FTP
	{.id = MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL,
         .target_system_offset = offsetof(mavlink_file_transfer_protocol_t, target_system),
         .target_component_offset = offsetof(mavlink_file_transfer_protocol_t, target_component),
         .receive = file_transfer},
#endif
	MAVLINK_PARAM_RECEIVERS,
};

static uint8_t system_status(const void *service)
{
	const struct mavlink_illuminator *const self = service;

	return thermal_allows_light(&light_of(self)->thermal) ? MAV_STATE_ACTIVE
	                                                      : MAV_STATE_CRITICAL;
}

static bool step(const struct mavlink_context *context)
{
	struct mavlink_illuminator *const self = context->component->service;

	if (!mavlink_self_test_step(&self->self_test, context)) {
		return false;
	}
#ifdef CONFIG_PHAROS_FTP
	if (!mavlink_ftp_step(&self->ftp, context)) {
		return false;
	}
#endif
#ifdef CONFIG_PHAROS_UPLOAD
	if (!mavlink_upload_step(&self->ftp.upload, context)) {
		return false;
	}
#endif
	return mavlink_params_step(&self->params, context);
}

static struct mavlink_params *params(void *service)
{
	return &((struct mavlink_illuminator *)service)->params;
}

static int64_t deadline_us(const void *service)
{
	const struct mavlink_illuminator *const self = service;
	const int64_t list_us = mavlink_params_deadline_us(&self->params);
	const int64_t test_us = mavlink_self_test_deadline_us(&self->self_test);
	int64_t due_us = list_us < test_us ? list_us : test_us;

#ifdef CONFIG_PHAROS_FTP
	const int64_t files_us = mavlink_ftp_deadline_us(&self->ftp);

	due_us = files_us < due_us ? files_us : due_us;
#endif
#ifdef CONFIG_PHAROS_UPLOAD
	const int64_t upload_us = mavlink_upload_deadline_us(&self->ftp.upload);

	due_us = upload_us < due_us ? upload_us : due_us;
#endif
	return due_us;
}

#ifdef CONFIG_PHAROS_FTP
#define CAPABILITIES (MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE | MAV_PROTOCOL_CAPABILITY_FTP)
#else
#define CAPABILITIES MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
#endif

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

_Static_assert(COUNT(messages) <= MAVLINK_MESSAGES_MAX, "a stream for each message");

static const struct mavlink_identity *identity(const void *service)
{
	const struct mavlink_illuminator *const self = service;

	return self->identity;
}

const struct mavlink_profile mavlink_illuminator_profile = {
	.capabilities = CAPABILITIES,
	.type = MAV_TYPE_ILLUMINATOR,
	.command_count = COUNT(commands),
	.message_count = COUNT(messages),
	.receiver_count = COUNT(receivers),
	.commands = commands,
	.messages = messages,
	.receivers = receivers,
	.system_status = system_status,
	.step = step,
	.deadline_us = deadline_us,
	.identity = identity,
	.params = params,
	.tell = tell,
};
