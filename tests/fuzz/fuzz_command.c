/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzzes the whole command thread: the real loop, nodes and core of app, with everything that one
 * peer after the other sends interleaved, and time that moves. Input: a byte for each of a few
 * parameters at start, then a small script:
 *
 *   op 0      bytes follow (count first): they arrive on UART 0
 *   op 1…2    a MAVLink message with a payload of the script's
 *   op 3      a MAVLink command to one of our components
 *   op 4      the same, rightly signed, or changed afterwards
 *   op 5      a DroneCAN transfer in as many frames as it takes
 *   op 6      a CAN frame of any kind
 *   op 7      an IMC packet, little endian, on the UART or as a datagram
 *   op 8…9    time moves; the thread wakes at each of its deadlines
 *   op 10     the thermal supervisor reports
 *   op 11     the shell sets a parameter, or the key; the button is pressed; a self-test
 *   op 12     what is around changes: links full or off the bus, the store or the driver fails
 *   op 13     flash has done what it was given, or failed
 *
 * Holds after each item: settings in their ranges, the plan in force is the device's, the store has
 * every parameter as it is; what leaves are whole, good frames, signed while there is a key, and
 * not more than a bound; the thread does not spin; who may do nothing has changed nothing: no
 * setting, parameter, key, system id, commander or sign of life, no update and no restart.
 */
#include <string.h>

#include "check.h"
#include "command_peers.h"
#include "command_world.h"
#include "core/light.h"
#include "proto/dronecan/endpoint.h"
#include "proto/mavlink/framer.h"
#include "threads/command.h"
#include "threads/frames.h"
#include "threads/imc_link.h"
#include "threads/mavlink_node.h"

/* More than the longest answer, all streams and a tunnel's queue together. */
#define SENT_MAX  600u
#define SPINS_MAX 300
#define NODE      68u
#define PEER      10u
#define OWN_IMC   0x8442u

static struct script script;

static struct pharos_device *device;
static struct mavlink_framer framer;
static struct dronecan_transport peer;
static int64_t until_us; /* time moves until then */
static int spins;

/* The item that the thread has, and what was so before it. */
static struct link_frame frame_item;
static struct dronecan_frame can_item;
static struct imc_frame imc_item;
static uint8_t call;
static struct {
	bool is_powerless;
	struct illuminator_settings settings;
	struct params params;
	struct arbiter arbiter;
	struct mavlink_signing_record signing;
	uint8_t system_id;
} before;

static uint8_t take(void)
{
	return script_take(&script);
}

/* --- what must hold --------------------------------------------------------------------------- */

static const struct illuminator *light(void)
{
	return &device->lamps[0].illuminator;
}

static bool may_nothing(enum security_way way)
{
	for (int right = SECURITY_EXIST; right < SECURITY_RIGHTS; right++) {
		if (security_check(&device->security, way, (enum security_right)right) ==
		    SECURITY_GRANTED) {
			return false;
		}
	}
	return true;
}

static void remember(bool is_powerless)
{
	before.is_powerless =
		is_powerless && pharos_device_deadline_us(device) > world.now_us && until_us == 0;
	before.settings = light()->settings;
	before.params = device->params;
	before.arbiter = device->lamps[0].arbiter;
	before.signing = mavlink_node_endpoint()->signing.now;
	before.system_id = mavlink_node_endpoint()->config.system_id;
}

static void check_powerless(void)
{
	const struct arbiter *const arbiter = &device->lamps[0].arbiter;
	const struct mavlink_endpoint *const mavlink = mavlink_node_endpoint();

	CHECK(memcmp(&before.params, &device->params, sizeof(before.params)) == 0);
	CHECK(before.settings.enable == light()->settings.enable);
	CHECK(before.settings.mode == light()->settings.mode);
	CHECK(before.settings.brightness_ppm == light()->settings.brightness_ppm);
	CHECK(before.settings.strobe_period_us == light()->settings.strobe_period_us);
	CHECK(before.settings.duty_ppm == light()->settings.duty_ppm);
	CHECK(before.arbiter.commander == arbiter->commander);
	CHECK(before.arbiter.commanded_us == arbiter->commanded_us);
	CHECK(before.arbiter.heard_us == arbiter->heard_us);
	CHECK(memcmp(before.signing.key, mavlink->signing.now.key, sizeof(before.signing.key)) ==
	      0);
	CHECK(before.system_id == mavlink->config.system_id);
	CHECK(!world.restarts);
}

static void check_all(void)
{
	const struct illuminator_settings *const s = &light()->settings;
	const struct light_plan *const plan = &light()->plan;

	CHECK(s->mode == ILLUMINATOR_MODE_INTERNAL || s->mode == ILLUMINATOR_MODE_SYNC);
	CHECK(s->brightness_ppm <= PPM_ONE && s->duty_ppm <= PPM_ONE);
	CHECK(s->strobe_period_us == 0 ||
	      (s->strobe_period_us >= 1000 && s->strobe_period_us <= 60000000));
	CHECK(plan->on == world.plan.on);
	CHECK(!plan->on ||
	      (plan->level_ppm == world.plan.level_ppm &&
	       plan->external_sync == world.plan.external_sync &&
	       plan->period_us == world.plan.period_us && plan->on_us == world.plan.on_us));
	for (struct param_set all = params_settable(); !param_set_is_empty(&all);) {
		const uint32_t i = param_set_take(&all);

		CHECK(device->params.values[i] == world.stored.values[i]);
	}
	CHECK(world.sent <= SENT_MAX);
	if (before.is_powerless) {
		check_powerless();
	}
	before.is_powerless = false;
	world.sent = 0;
}

void command_sent_mavlink(const uint8_t *bytes, size_t length)
{
	struct mavlink_frame frame;

	CHECK(mavlink_frame_view(bytes, length, &frame) && frame.length == length);
	CHECK(frame.has_signature == mavlink_node_endpoint()->signing.on);
	CHECK(frame.system_id == mavlink_node_endpoint()->config.system_id);
}

/* --- MAVLink ---------------------------------------------------------------------------------- */

static void give_frame(struct inbox_item *item, const uint8_t *bytes, size_t length, bool trusted)
{
	const enum security_way way = trusted ? SECURITY_WAY_MAVLINK_SIGNED : SECURITY_WAY_MAVLINK;

	frame_item.link = 0;
	frame_item.length = (uint16_t)length;
	memcpy(frame_item.bytes, bytes, length);
	*item = (struct inbox_item){.kind = INBOX_FRAME, .frame = &frame_item};
	remember(may_nothing(way));
}

static bool next_of_framer(struct inbox_item *item)
{
	struct mavlink_frame frame;

	if (!mavlink_framer_next(&framer, &frame)) {
		return false;
	}
	give_frame(item, frame.bytes, frame.length, false);
	return true;
}

static bool raw(struct inbox_item *item)
{
	const size_t left = (size_t)(script.end - script.at);
	size_t count = take();

	count = count < left ? count : (left > 0 ? left - 1 : 0);
	script.at += mavlink_framer_write(&framer, script.at, count);
	return next_of_framer(item);
}

static bool message(struct inbox_item *item)
{
	uint8_t bytes[MAVLINK_FRAME_MAX];
	const size_t length = peer_message(&script, bytes);

	if (length > 0) {
		give_frame(item, bytes, length, false);
	}
	return length > 0;
}

static bool command(struct inbox_item *item)
{
	uint8_t bytes[MAVLINK_FRAME_MAX];

	give_frame(item, bytes, peer_command(&script, bytes), false);
	return true;
}

static bool signed_command(struct inbox_item *item)
{
	const struct mavlink_signing *const own = &mavlink_node_endpoint()->signing;
	uint8_t bytes[MAVLINK_FRAME_MAX];
	bool is_right;
	const size_t length = peer_signed_command(&script, world.now_us, own, bytes, &is_right);

	if (length > 0) {
		give_frame(item, bytes, length, is_right);
	}
	return length > 0;
}

/* --- DroneCAN --------------------------------------------------------------------------------- */

/* It may carry MAVLink as well. */
static void give_can(struct inbox_item *item)
{
	*item = (struct inbox_item){.kind = INBOX_CAN, .can = &can_item};
	remember(may_nothing(SECURITY_WAY_DRONECAN) && may_nothing(SECURITY_WAY_MAVLINK));
}

static bool next_of_peer(struct inbox_item *item)
{
	if (!dronecan_transport_next_frame(&peer, world.now_us, &can_item)) {
		return false;
	}
	dronecan_transport_frame_sent(&peer);
	give_can(item);
	return true;
}

static bool transfer(struct inbox_item *item)
{
	return peer_transfer(&script, world.now_us, &peer, NODE) && next_of_peer(item);
}

static bool can_frame(struct inbox_item *item)
{
	peer_can_frame(&script, &can_item);
	give_can(item);
	return true;
}

/* --- IMC -------------------------------------------------------------------------------------- */

static bool packet(struct inbox_item *item)
{
	peer_packet(&script, OWN_IMC, UART_OF_IMC, IMC_LINK_DATAGRAMS, &imc_item);
	*item = (struct inbox_item){.kind = INBOX_IMC, .imc = &imc_item};
	remember(may_nothing(SECURITY_WAY_IMC));
	return true;
}

/* --- the rest --------------------------------------------------------------------------------- */

static bool heat(struct inbox_item *item)
{
	const uint8_t choice = take();

	*item = (struct inbox_item){
		.kind = INBOX_THERMAL,
		.thermal = {
			.state = (enum thermal_state)(choice % 3),
			.sensor = choice & 0x40 ? THERMAL_SENSOR_FAILED : THERMAL_SENSOR_OK,
			.fault = choice & 0x40 ? THERMAL_FAULT_STUCK : THERMAL_FAULT_NONE,
			.flags = choice % 3,
			.temp_mdegc = choice * 1000,
			.temp_valid = (choice & 0x40) == 0,
			.dark = (choice & 0x20) != 0,
		}};
	return true;
}

static void flash_is_done(const char *failure)
{
	void (*const done)(const char *failure) = world.flashed;

	world.is_flashing = false;
	world.flashed = failure == NULL && !world.is_last ? done : NULL;
	done(failure);
}

/* What the shell, the button or flash has the thread run. */
void command_call(struct pharos_device *its)
{
	const struct device_who shell = {.way = SECURITY_WAY_SHELL};
	const struct device_who button = {.way = SECURITY_WAY_BUTTON};
	const struct illuminator_event on = {.kind = ILLUMINATOR_EVENT_ON_OFF,
	                                     .on_off = (call & 16) != 0};
	struct mavlink_signing_record record = {0};
	enum self_test_state obstacle;
	uint8_t value[4];

	device = its;
	switch (call & 15) {
	case 0:
		break;
	case 1:
		memset(record.key, call & 32 ? 1 : 0, sizeof(record.key));
		mavlink_node_set_key(&record);
		break;
	case 2:
		(void)pharos_device_apply(device, world.now_us, &button, 0, &on, 1);
		break;
	case 3:
		(void)pharos_device_test(device, world.now_us, &shell, 0, PPM_ONE, &obstacle);
		break;
	case 4:
		flash_is_done((call & 16) != 0 ? "flash" : NULL);
		break;
	default:
		script_take_bytes(&script, value, sizeof(value));
		(void)pharos_device_set_param(device, world.now_us, &shell,
		                              (uint32_t)value[0] % PARAM_COUNT,
		                              (int32_t)((uint32_t)(int8_t)value[1] << 16 |
		                                        (uint32_t)value[2] << 8 | value[3]));
	}
}

static bool call_of(struct inbox_item *item, uint8_t what)
{
	call = what;
	*item = (struct inbox_item){.kind = INBOX_CALL};
	return true;
}

static bool from_outside(struct inbox_item *item)
{
	const uint8_t what = take();

	return (what & 15) != 4 && call_of(item, what);
}

static bool from_flash(struct inbox_item *item)
{
	return world.is_flashing && call_of(item, take() & 1 ? 4 | 16 : 4);
}

static bool around(void)
{
	const uint8_t choice = take();

	world.is_full = (choice & 1) != 0;
	world.is_off_bus = (choice & 2) != 0;
	world.fails = (choice & 4) != 0;
	world.driver_fault = (choice & 8) != 0;
	return false;
}

static bool time_moves(void)
{
	until_us = world.now_us + 1 + ((int64_t)take() * 100000) + take();
	return false;
}

/* --- the script ------------------------------------------------------------------------------- */

static bool next_op(struct inbox_item *item)
{
	switch (take() % 14) {
	case 0:
		return raw(item);
	case 1:
	case 2:
		return message(item);
	case 3:
		return command(item);
	case 4:
		return signed_command(item);
	case 5:
		return transfer(item);
	case 6:
		return can_frame(item);
	case 7:
		return packet(item);
	case 10:
		return heat(item);
	case 11:
		return from_outside(item);
	case 12:
		return around();
	case 13:
		return from_flash(item);
	default:
		return time_moves();
	}
}

bool command_next(int64_t deadline_us, struct inbox_item *item)
{
	if (device != NULL) {
		check_all();
	} else {
		return call_of(item, 0); /* so that we get to know it */
	}
	if (deadline_us <= world.now_us) {
		CHECK(++spins < SPINS_MAX);
		return true;
	}
	spins = 0;
	while (until_us == 0) {
		if (next_of_framer(item) || next_of_peer(item)) {
			return true;
		}
		if (script.at == script.end) {
			return false;
		}
		if (next_op(item)) {
			return true;
		}
	}
	world.now_us = deadline_us < until_us ? deadline_us : until_us;
	until_us = world.now_us == until_us ? 0 : until_us;
	return true;
}

/* The parameters that decide most of what may happen. */
static struct params at_start(void)
{
	struct params stored;

	params_init(&stored);
	stored.values[PARAM_GMB_ENABLE] = take() & 1;
	stored.values[PARAM_MAV_SYSID] = take() & 1;
	stored.values[PARAM_MAV_ROUTE] = take() & 1;
	stored.values[PARAM_MAV_KEY_CAN] = take() % 3;
	stored.values[PARAM_MAV_KEY_IMC] = take() % 3;
	stored.values[PARAM_LGT_SRC_EXCL] = take() & 7;
	stored.values[PARAM_CAN_ACT_BRT] = take() & 1;
	return stored;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	script = (struct script){data, data + size};

	const struct params stored = at_start();
	const uint8_t key = take();

	command_world_init(&stored);
	memset(world.signing.key, key & 1, sizeof(world.signing.key));
	device = NULL;
	until_us = 0;
	spins = 0;
	memset(&before, 0, sizeof(before));
	mavlink_framer_init(&framer);
	dronecan_transport_init(&peer, NULL, 0, PEER, false, 1);
	command_init();
	command_world_run();
	if (world.restarts && before.is_powerless) {
		check_powerless();
	}
	return 0;
}
