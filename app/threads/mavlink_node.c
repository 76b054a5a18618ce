/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/mavlink_node.h"

#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/printk.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/probe.h>
#include <pharos/drivers/thermistor.h>

#include "proto/mavlink/gimbal_service.h"
#include "proto/mavlink/illuminator_service.h"
#include "threads/can_node.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/firmware.h"
#include "threads/identity.h"
#include "threads/inputs.h"
#include "threads/links.h"
#include "threads/startup.h"
#include "threads/storage.h"

LOG_MODULE_REGISTER(mavlink);

/* MAV_SYSID 0 leaves the choice to the vehicle; until one is heard, this. */
#define SYSTEM_ID_FALLBACK 1

/* Until an acknowledged reboot: frames leave the wires, and settings reach the store. */
#define REBOOT_DELAY_US 500000

/* What has not started, or stands wrong, is told again: whoever listens may not have been there
 * before.
 */
#define TOLD_AGAIN_US (30 * US_PER_S)

static struct pharos_device *device;
static int64_t reboot_us;
static struct mavlink_endpoint endpoint;
static struct mavlink_illuminator illuminator;
#ifdef CONFIG_PHAROS_GIMBAL
static struct mavlink_gimbal gimbal;
#endif
static struct mavlink_outbox out;
static const uint8_t *received; /* what may have to go on to other links */
static size_t received_length;
/* What people have been told, and when the next may be. */
static struct {
	enum startup_step startup; /* the next step to look at; STARTUP_STEPS: all are told */
	int64_t startup_us;
	uint32_t storage_failures;
	int64_t storage_us;
	bool driver_fault;
	int64_t driver_us;
	int64_t clash_us;
	int64_t simulated_us;
} told;

/* The gimbal, if there is one: a component of its own. */
static void add_gimbal(int64_t now_us)
{
#ifdef CONFIG_PHAROS_GIMBAL
	const uint8_t id = (uint8_t)device->params.values[PARAM_GMB_COMPID];

	if (!pharos_device_has_gimbal(device)) {
		return;
	}
	if (device->params.values[PARAM_MAV_COMPID] == id) {
		LOG_ERR("GMB_COMPID is the light's: no gimbal over MAVLink");
		return;
	}
	mavlink_gimbal_init(&gimbal, device, identity_get());
	mavlink_endpoint_add(&endpoint, now_us, id, &mavlink_gimbal_profile, &gimbal);
#endif
}

#ifdef CONFIG_PHAROS_SIGNING
/* A key that comes over MAVLink comes on a secure link: there is none while MAVLink is excluded. */
static uint8_t secure_links(void)
{
	const struct device_who who = {.way = SECURITY_WAY_MAVLINK_SIGNED};

	return pharos_device_may(device, &who, SECURITY_KEY)
	               ? (uint8_t)device->params.values[PARAM_MAV_SECURE]
	               : 0;
}
#endif

/* The device's security table stands on whether there is a key. */
static void tell_key(void)
{
#ifdef CONFIG_PHAROS_SIGNING
	pharos_device_set_keyed(device, clock_now_us(), endpoint.signing.on);
#endif
}

static void configure(void)
{
#ifdef CONFIG_PHAROS_SIGNING
	mavlink_endpoint_set_secure_links(&endpoint, secure_links());
#endif
#ifdef CONFIG_PHAROS_ROUTING
	const bool routing = device->params.values[PARAM_MAV_ROUTE] != 0;

	if (routing != endpoint.config.routing) {
		mavlink_endpoint_set_routing(&endpoint, routing);
		link_set_opaque(routing);
	}
#endif
}

void mavlink_node_init(struct pharos_device *its)
{
	const int64_t now_us = clock_now_us();
	const int32_t system_id = its->params.values[PARAM_MAV_SYSID];
	struct mavlink_endpoint_config config = {
		.system_id = (uint8_t)(system_id != 0 ? system_id : SYSTEM_ID_FALLBACK),
		.adopt = system_id == 0,
		.links = (uint8_t)links_mask(),
	};
	char text[IDENTITY_BOOT_TEXT_MAX];

	device = its;
	reboot_us = TIME_NEVER_US;
	mavlink_outbox_clear(&out);
	memset(&told, 0, sizeof(told));
	told.startup = STARTUP_STEPS;
	mavlink_illuminator_init(&illuminator, device, 0, identity_get());
	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		config.rates[link] = links_rate(link);
	}
	mavlink_endpoint_init(&endpoint, &config);
	configure();
#ifdef CONFIG_PHAROS_SIGNING
	struct mavlink_signing_record stored;

	storage_load_signing(&stored);
	mavlink_endpoint_restore_key(&endpoint, now_us, &stored);
	tell_key();
#endif
	mavlink_endpoint_add(&endpoint, now_us, (uint8_t)device->params.values[PARAM_MAV_COMPID],
	                     &mavlink_illuminator_profile, &illuminator);
	add_gimbal(now_us);
	identity_boot_text(text);
	mavlink_endpoint_text(&endpoint, now_us, 6 /* MAV_SEVERITY_INFO */, text);
}

#ifdef CONFIG_PHAROS_SIGNING
void mavlink_node_set_key(const struct mavlink_signing_record *record)
{
	mavlink_endpoint_set_key(&endpoint, clock_now_us(), record);
	tell_key();
}
#endif

/* After our own frames, so that others' never delay them. */
static void forward(void)
{
#ifdef CONFIG_PHAROS_ROUTING
	for (uint8_t link = 0; out.forward >> link != 0; link++) {
		if ((out.forward & BIT(link)) != 0) {
			links_forward(link, received, received_length);
		}
	}
	out.forward = 0;
#endif
}

/* --- firmware update -------------------------------------------------------------------------- */

#ifdef CONFIG_PHAROS_UPLOAD
static void upload_done(const char *failure)
{
	struct mavlink_upload *const upload = &illuminator.ftp.upload;
	const int64_t now_us = clock_now_us();
	char text[MAVLINK_TEXT_BYTES];

	mavlink_upload_done(upload, now_us, failure);
	if (failure != NULL) {
		snprintk(text, sizeof(text), "Update: %s", failure);
		mavlink_endpoint_text(&endpoint, now_us, 3 /* MAV_SEVERITY_ERROR */, text);
	} else if (upload->state == MAVLINK_UPLOAD_INSTALLED) {
		mavlink_endpoint_text(&endpoint, now_us, 5 /* MAV_SEVERITY_NOTICE */,
		                      "Update: starts at the next reset");
	}
}
#endif

static void perform_upload(void)
{
#ifdef CONFIG_PHAROS_UPLOAD
	const struct mavlink_upload *const upload = &illuminator.ftp.upload;

	switch (out.upload) {
	case MAVLINK_OUTBOX_UPLOAD_NOTHING:
		break;
	case MAVLINK_OUTBOX_UPLOAD_BEGIN:
		firmware_begin(upload_done);
		break;
	case MAVLINK_OUTBOX_UPLOAD_BLOCK:
		firmware_write(upload->buffer, MAVLINK_UPLOAD_BLOCK, false);
		break;
	case MAVLINK_OUTBOX_UPLOAD_LAST:
		firmware_write(upload->buffer, upload->fill, true);
		break;
	case MAVLINK_OUTBOX_UPLOAD_ABORT:
		firmware_abort("the upload broke off");
		break;
	}
#endif
}

/* --- what the command thread calls ------------------------------------------------------------ */

void mavlink_node_flush(void)
{
	perform_upload();
	if (out.command != 0) {
		probe_set(devices.probe, PROBE_COMMAND, out.command);
	}
	for (uint16_t i = 0; i < out.count; i++) {
		const struct mavlink_outbox_frame *const frame = &out.frames[i];

		links_send(frame->link, &out.bytes[frame->offset], frame->length);
	}
#ifdef CONFIG_PHAROS_SIGNING
	if (out.store_signing) {
		storage_save_signing(&out.signing);
	}
#endif
	if (out.reboot) {
		reboot_us = clock_now_us() + REBOOT_DELAY_US;
	}
	forward();
	mavlink_outbox_clear(&out);
}

void mavlink_node_take(uint8_t link, const uint8_t *bytes, size_t length)
{
	received = bytes;
	received_length = length;
#ifdef CONFIG_PHAROS_UPLOAD
	illuminator.ftp.upload.is_taken = firmware_is_busy();
#endif
	mavlink_endpoint_receive(&endpoint, clock_now_us(), link, bytes, length, &out);
	tell_key();
}

void mavlink_node_tell(const struct device_effects *effects)
{
	if (param_set_touches(&effects->params, PARAM_GROUP_MAVLINK) ||
	    param_set_touches(&effects->params, PARAM_GROUP_ARBITER)) {
		configure();
	}
	mavlink_endpoint_tell(&endpoint, clock_now_us(), effects);
}

/* What could not be stored is gone after the next reset: people should know. */
static void tell_storage_failure(int64_t now_us)
{
	const struct storage_stats stats = storage_stats_get();
	char text[MAVLINK_TEXT_BYTES];

	if (stats.failures == told.storage_failures || now_us < told.storage_us) {
		return;
	}
	told.storage_failures = stats.failures;
	told.storage_us = now_us + MAVLINK_NOTICE_GAP_US;
	snprintk(text, sizeof(text), "Settings can't be stored: error %d", stats.last_error);
	mavlink_endpoint_text(&endpoint, now_us, 3 /* MAV_SEVERITY_ERROR */, text);
}

/* What has not started: a text for each step. */
static void tell_startup(int64_t now_us)
{
	char text[MAVLINK_TEXT_BYTES];

	if (told.startup == STARTUP_STEPS) {
		if (now_us < told.startup_us) {
			return;
		}
		told.startup = 0;
		told.startup_us = now_us + TOLD_AGAIN_US;
	}
	told.startup = startup_failed(told.startup);
	if (told.startup != STARTUP_STEPS) {
		snprintk(text, sizeof(text), "Start failed: %s, error %d",
		         startup_name(told.startup), startup_result(told.startup));
		mavlink_endpoint_text(&endpoint, now_us,
		                      startup_allows_light() ? 3 /* MAV_SEVERITY_ERROR */
		                                             : 2 /* MAV_SEVERITY_CRITICAL */,
		                      text);
		told.startup++;
	}
}

/* The lamp cannot be driven, or its driver tells of a fault; or all is well again. */
static void tell_driver_fault(int64_t now_us)
{
	struct light_state light;

	light_get(devices.light, &light);
	const bool fault = inputs_get().driver_fault || light.error != 0;

	if (fault == told.driver_fault || now_us < told.driver_us) {
		return;
	}
	told.driver_fault = fault;
	told.driver_us = now_us + MAVLINK_NOTICE_GAP_US;
	mavlink_endpoint_text(&endpoint, now_us,
	                      fault ? 3 /* MAV_SEVERITY_ERROR */ : 5 /* MAV_SEVERITY_NOTICE */,
	                      fault ? "Lamp driver reports a fault" : "Lamp driver is well again");
}

static void tell_lock(int64_t now_us)
{
#ifdef CONFIG_PHAROS_SIGNING
	static int64_t next_us;

	if (now_us >= next_us && endpoint.signing.locked) {
		next_us = now_us + TOLD_AGAIN_US;
		mavlink_endpoint_text(&endpoint, now_us, 2 /* MAV_SEVERITY_CRITICAL */,
		                      "Key lost: obeys only its console (signing key)");
	}
#endif
}

static void tell_clash(int64_t now_us)
{
	char text[MAVLINK_TEXT_BYTES];

	_Static_assert(sizeof(text) >= CAN_NODE_CLASH_TEXT_MAX, "it fits");
	if (now_us >= told.clash_us && can_node_clash_text(text)) {
		told.clash_us = now_us + TOLD_AGAIN_US;
		mavlink_endpoint_text(&endpoint, now_us, 4 /* MAV_SEVERITY_WARNING */, text);
	}
}

/* The lamp is lit, and nothing protects it: somebody has said so, and everybody is to know. */
static void tell_simulated(int64_t now_us)
{
	if (thermistor_is_simulated(devices.thermistor) && now_us >= told.simulated_us) {
		told.simulated_us = now_us + TOLD_AGAIN_US;
		mavlink_endpoint_text(&endpoint, now_us, 4 /* MAV_SEVERITY_WARNING */,
		                      "Simulated sensor: lamp unprotected from heat");
	}
}

void mavlink_node_warn(void)
{
	const int64_t now_us = clock_now_us();

	tell_startup(now_us);
	tell_storage_failure(now_us);
	tell_driver_fault(now_us);
	tell_lock(now_us);
	tell_clash(now_us);
	tell_simulated(now_us);
}

void mavlink_node_step(void)
{
	const int64_t now_us = clock_now_us();

	if (reboot_us <= now_us) {
		light_off_now(devices.light);
		sys_reboot(SYS_REBOOT_COLD);
	}
	mavlink_endpoint_step(&endpoint, now_us, &out);
}

int64_t mavlink_node_deadline_us(void)
{
	return MIN(mavlink_endpoint_deadline_us(&endpoint), reboot_us);
}

void mavlink_node_link_up(uint8_t link)
{
	mavlink_endpoint_link_up(&endpoint, clock_now_us(), link);
}

void mavlink_node_link_down(uint8_t link)
{
	mavlink_endpoint_link_down(&endpoint, link);
}

const struct mavlink_endpoint *mavlink_node_endpoint(void)
{
	return &endpoint;
}

#ifdef CONFIG_PHAROS_GIMBAL
const struct mavlink_gimbal_stats *mavlink_node_gimbal_stats(void)
{
	return &gimbal.stats;
}
#endif
