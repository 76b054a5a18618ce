/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The IMC messages that this device speaks, as on the wire (IMC 5.4.31): fields in wire order, each
 * of the type that the wire has. messages.c names the fields once more, in that order; everything
 * else (sizes, codec) follows from the two. Messages without fields have no struct.
 *
 * Any field may hold anything: an enumeration out of range, a NaN. The services refuse these.
 *
 * To add a message: a struct, a member of the union, a row in messages.c.
 */
#ifndef PHAROS_PROTO_IMC_MESSAGES_H
#define PHAROS_PROTO_IMC_MESSAGES_H

#include "proto/imc/limits.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* plaintext and rawdata: any bytes, no terminator. Decoded, it points into the packet's bytes. */
struct imc_text {
	const char *bytes;
	uint16_t length;
};

enum imc_id {
	IMC_ENTITY_STATE = 1,
	IMC_QUERY_ENTITY_STATE = 2,
	IMC_ENTITY_INFO = 3,
	IMC_QUERY_ENTITY_INFO = 4,
	IMC_ENTITY_LIST = 5,
	IMC_ENTITY_ACTIVATION_STATE = 14,
	IMC_QUERY_ENTITY_ACTIVATION_STATE = 15,
	IMC_HEARTBEAT = 150,
	IMC_ANNOUNCE = 151,
	IMC_ANNOUNCE_SERVICE = 152,
	IMC_CAMERA_ZOOM = 300,
	IMC_SET_THRUSTER_ACTUATION = 301,
	IMC_SET_SERVO_POSITION = 302,
	IMC_SET_CONTROL_SURFACE_DEFLECTION = 303,
	IMC_REMOTE_ACTIONS_REQUEST = 304,
	IMC_REMOTE_ACTIONS = 305,
	IMC_BUTTON_EVENT = 306,
	IMC_LCD_CONTROL = 307,
	IMC_POWER_OPERATION = 308,
	IMC_POWER_CHANNEL_CONTROL = 309,
	IMC_QUERY_POWER_CHANNEL_STATE = 310,
	IMC_POWER_CHANNEL_STATE = 311,
	IMC_LED_BRIGHTNESS = 312,
	IMC_QUERY_LED_BRIGHTNESS = 313,
	IMC_SET_LED_BRIGHTNESS = 314,
	IMC_SET_PWM = 315,
	IMC_PWM = 316,
	IMC_ENTITY_PARAMETER = 801,
	IMC_ENTITY_PARAMETERS = 802,
	IMC_QUERY_ENTITY_PARAMETERS = 803,
	IMC_SET_ENTITY_PARAMETERS = 804,
	IMC_SAVE_ENTITY_PARAMETERS = 805,
	IMC_GPIO_STATE = 2000,
	IMC_GPIO_STATE_GET = 2001,
	IMC_GPIO_STATE_SET = 2002,
	IMC_VERSION_INFO = 2021,
};

/* Header addresses: everyone, all entities. */
#define IMC_DST_ALL    0xFFFFu
#define IMC_ENTITY_ALL 255u

/* Ids of sensors, as this device is one. */
#define IMC_ID_SENSORS_FIRST 0x8000u
#define IMC_ID_SENSORS_LAST  0x8FFFu

/* --- entities and the node -------------------------------------------------------------------- */

enum imc_entity_state_state {
	IMC_ENTITY_STATE_BOOT = 0,
	IMC_ENTITY_STATE_NORMAL = 1,
	IMC_ENTITY_STATE_FAULT = 2,
	IMC_ENTITY_STATE_ERROR = 3,
	IMC_ENTITY_STATE_FAILURE = 4,
};

struct imc_entity_state {
	uint8_t state;
	uint8_t flags;
	struct imc_text description;
};

struct imc_entity_info {
	uint8_t id;
	struct imc_text label;
	struct imc_text component;
	uint16_t act_time;
	uint16_t deact_time;
};

struct imc_query_entity_info {
	uint8_t id;
};

enum imc_entity_list_op {
	IMC_ENTITY_LIST_REPORT = 0,
	IMC_ENTITY_LIST_QUERY = 1,
};

/* list: "Name=id;Name=id". */
struct imc_entity_list {
	uint8_t op;
	struct imc_text list;
};

enum imc_entity_activation {
	IMC_ENTITY_INACTIVE = 0,
	IMC_ENTITY_ACTIVE = 1,
};

struct imc_entity_activation_state {
	uint8_t state;
	struct imc_text error;
};

/* lat, lon in rad, height in m; services: URIs between semicolons. */
struct imc_announce {
	struct imc_text sys_name;
	uint8_t sys_type;
	uint16_t owner;
	double lat;
	double lon;
	float height;
	struct imc_text services;
};

struct imc_announce_service {
	struct imc_text service;
	uint8_t service_type;
};

struct imc_entity_parameter {
	struct imc_text name;
	struct imc_text value;
};

/*
 * A message list that holds EntityParameters only, as on the wire: imc_parameters_next() reads it,
 * imc_parameters_add() builds it. size: bytes of all items.
 */
struct imc_parameter_list {
	const uint8_t *bytes;
	uint16_t size;
	uint16_t count;
	bool big_endian;
};

/* Of EntityParameters and SetEntityParameters. name: the entity's. */
struct imc_entity_parameters {
	struct imc_text name;
	struct imc_parameter_list params;
};

struct imc_query_entity_parameters {
	struct imc_text name;
	struct imc_text visibility;
	struct imc_text scope;
};

struct imc_save_entity_parameters {
	struct imc_text name;
};

enum imc_version_info_op {
	IMC_VERSION_REQUEST = 0,
	IMC_VERSION_REPLY = 1,
};

struct imc_version_info {
	uint8_t op;
	struct imc_text version;
	struct imc_text description;
};

/* --- actuation -------------------------------------------------------------------------------- */

enum imc_camera_zoom_action {
	IMC_ZOOM_RESET = 0,
	IMC_ZOOM_IN = 1,
	IMC_ZOOM_OUT = 2,
	IMC_ZOOM_STOP = 3,
};

struct imc_camera_zoom {
	uint8_t id;
	uint8_t zoom;
	uint8_t action;
};

/* value -1…1. */
struct imc_set_thruster_actuation {
	uint8_t id;
	float value;
};

/* value in rad, -pi/2…pi/2. */
struct imc_set_servo_position {
	uint8_t id;
	float value;
};

/* angle in rad. */
struct imc_set_control_surface_deflection {
	uint8_t id;
	float angle;
};

enum imc_remote_actions_request_op {
	IMC_REMOTE_ACTIONS_REPORT = 0,
	IMC_REMOTE_ACTIONS_QUERY = 1,
	IMC_REMOTE_ACTIONS_REGISTER = 2,
};

/* actions: "Name=Type;Name=Type". */
struct imc_remote_actions_request {
	uint8_t op;
	struct imc_text actions;
};

/* actions: "Name=value;Name=value". */
struct imc_remote_actions {
	struct imc_text actions;
};

struct imc_button_event {
	uint8_t button;
	uint8_t value;
};

enum imc_lcd_control_op {
	IMC_LCD_OFF = 0,
	IMC_LCD_ON = 1,
	IMC_LCD_CLEAR = 2,
	IMC_LCD_WRITE0 = 3,
	IMC_LCD_WRITE1 = 4,
};

struct imc_lcd_control {
	uint8_t op;
	struct imc_text text;
};

enum imc_power_operation_op {
	IMC_POWER_DOWN = 0,
	IMC_POWER_DOWN_IN_PROGRESS = 1,
	IMC_POWER_DOWN_ABORTED = 2,
	IMC_POWER_SCHEDULE_DOWN = 3,
	IMC_POWER_UP = 4,
	IMC_POWER_UP_IN_PROGRESS = 5,
	IMC_POWER_SCHEDULE_UP = 6,
};

/* Both times in s. */
struct imc_power_operation {
	uint8_t op;
	float time_remain;
	double sched_time;
};

enum imc_power_channel_op {
	IMC_CHANNEL_OFF = 0,
	IMC_CHANNEL_ON = 1,
	IMC_CHANNEL_TOGGLE = 2,
	IMC_CHANNEL_SCHEDULE_ON = 3,
	IMC_CHANNEL_SCHEDULE_OFF = 4,
	IMC_CHANNEL_RESET_SCHEDULES = 5,
	IMC_CHANNEL_SAVE = 6,
	IMC_CHANNEL_RESTART = 7,
};

/* sched_time in s, from now. */
struct imc_power_channel_control {
	struct imc_text name;
	uint8_t op;
	double sched_time;
};

/* state 0 off, 1 on. */
struct imc_power_channel_state {
	struct imc_text name;
	uint8_t state;
};

/* Of LedBrightness and SetLedBrightness. */
struct imc_led_brightness {
	struct imc_text name;
	uint8_t value;
};

struct imc_query_led_brightness {
	struct imc_text name;
};

/* Of SetPWM and PWM. Both times in us, duty_cycle <= period. */
struct imc_pwm {
	uint8_t id;
	uint32_t period;
	uint32_t duty_cycle;
};

/* Of GpioState and GpioStateSet. */
struct imc_gpio_state {
	struct imc_text name;
	uint8_t value;
};

struct imc_gpio_state_get {
	struct imc_text name;
};

/* --- any message ------------------------------------------------------------------------------ */

/* id tells which member holds. */
struct imc_message {
	uint16_t id; /* enum imc_id */
	union {
		struct imc_entity_state entity_state;
		struct imc_entity_info entity_info;
		struct imc_query_entity_info query_entity_info;
		struct imc_entity_list entity_list;
		struct imc_entity_activation_state entity_activation_state;
		struct imc_announce announce;
		struct imc_announce_service announce_service;
		struct imc_entity_parameter entity_parameter;
		struct imc_entity_parameters entity_parameters; /* 802 and 804 */
		struct imc_query_entity_parameters query_entity_parameters;
		struct imc_save_entity_parameters save_entity_parameters;
		struct imc_version_info version_info;
		struct imc_camera_zoom camera_zoom;
		struct imc_set_thruster_actuation set_thruster_actuation;
		struct imc_set_servo_position set_servo_position;
		struct imc_set_control_surface_deflection set_control_surface_deflection;
		struct imc_remote_actions_request remote_actions_request;
		struct imc_remote_actions remote_actions;
		struct imc_button_event button_event;
		struct imc_lcd_control lcd_control;
		struct imc_power_operation power_operation;
		struct imc_power_channel_control power_channel_control;
		struct imc_power_channel_state power_channel_state;
		struct imc_led_brightness led_brightness; /* 312 and 314 */
		struct imc_query_led_brightness query_led_brightness;
		struct imc_pwm pwm;               /* 315 and 316 */
		struct imc_gpio_state gpio_state; /* 2000 and 2002 */
		struct imc_gpio_state_get gpio_state_get;
	};
};

/* How a field lies on the wire and in its struct. */
enum imc_field_kind {
	IMC_U8,
	IMC_U16,
	IMC_U32,
	IMC_F32,
	IMC_F64,
	IMC_TEXT,
	IMC_PARAMETER_LIST,
};

struct imc_field {
	uint8_t kind;   /* enum imc_field_kind */
	uint8_t offset; /* into the message's struct */
};

struct imc_type {
	uint16_t id;
	uint8_t fields_count;
	const struct imc_field *fields;
	const char *name; /* the specification's, for people */
};

/* The type with this id, constant; NULL: not one of ours. Any context. */
const struct imc_type *imc_type_find(uint16_t id);

/* All of them, by rising id. */
extern const struct imc_type imc_types[];
extern const size_t imc_types_count;

#endif
