/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/param_service.h"

#include "core/param_units.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

#define NAME_BYTES 16
#define BY_NAME    (-1)

_Static_assert(NAME_BYTES == PARAMS_NAME_MAX, "a name fits its field");
_Static_assert(sizeof(((mavlink_param_value_t *)0)->param_id) == NAME_BYTES, "common.xml");
_Static_assert(PARAM_COUNT <= INT16_MAX, "an index fits its field");

static size_t name_length(const char *name)
{
	size_t length = 0;

	while (length < NAME_BYTES && name[length] != '\0') {
		length++;
	}
	return length;
}

/* --- whose ------------------------------------------------------------------------------------ */

bool mavlink_params_is(enum mavlink_params_share share, uint32_t index)
{
	bool is_gimbals = params_info(index)->group == PARAM_GROUP_GIMBAL;

#ifdef CONFIG_PHAROS_GIMBAL
	is_gimbals = is_gimbals && index != PARAM_GMB_ENABLE && index != PARAM_GMB_COMPID;
#endif
	return is_gimbals == (share == MAVLINK_PARAMS_GIMBAL);
}

/* How many of the share come before the parameter. */
static uint16_t place_of(enum mavlink_params_share share, uint32_t index)
{
	uint16_t place = 0;

	for (uint32_t i = 0; i < index; i++) {
		if (mavlink_params_is(share, i)) {
			place++;
		}
	}
	return place;
}

uint16_t mavlink_params_count(enum mavlink_params_share share)
{
	return place_of(share, PARAM_COUNT);
}

/* PARAM_COUNT: the share ends before that place. */
static uint32_t at_place(enum mavlink_params_share share, uint32_t place)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (mavlink_params_is(share, i) && place-- == 0) {
			return i;
		}
	}
	return PARAM_COUNT;
}

/* PARAM_COUNT: none of that name is in the share. */
static uint32_t find(const struct mavlink_params *self, const char *name)
{
	const uint32_t index = params_find(name, name_length(name));

	return index < PARAM_COUNT && mavlink_params_is(self->share, index) ? index
	                                                                    : (uint32_t)PARAM_COUNT;
}

static struct mavlink_params *params_of(const struct mavlink_context *context)
{
	return context->component->profile->params(context->component->service);
}

void mavlink_params_init(struct mavlink_params *self, struct pharos_device *device,
                         enum mavlink_params_share share)
{
	*self = (struct mavlink_params){
		.device = device,
		.share = share,
		.due_us = TIME_NEVER_US,
		.answered = PARAM_COUNT,
	};
}

/* --- answers --------------------------------------------------------------------------------- */

static void fill_value(const struct mavlink_params *self, uint32_t index,
                       mavlink_param_value_t *wire)
{
	const struct param_info *const info = params_info(index);
	const uint32_t real = param_to_real(info, self->device->params.values[index]);

	memset(wire, 0, sizeof(*wire));
	memcpy(&wire->param_value, &real, sizeof(wire->param_value));
	wire->param_count = mavlink_params_count(self->share);
	wire->param_index = place_of(self->share, index);
	memcpy(wire->param_id, info->name, name_length(info->name));
	wire->param_type = MAV_PARAM_TYPE_REAL32;
}

static const struct mavlink_kind value_kind = MAVLINK_KIND(PARAM_VALUE);

static void answer(const struct mavlink_params *self, const struct mavlink_context *context,
                   uint32_t index)
{
	mavlink_param_value_t wire;

	fill_value(self, index, &wire);
	(void)mavlink_send(context, context->link, &value_kind, &wire);
}

/* index BY_NAME, or what was asked by index, when name is NULL. */
static void refuse(const struct mavlink_context *context, const char *name, int16_t index,
                   uint8_t error)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PARAM_ERROR);
	mavlink_param_error_t wire;

	memset(&wire, 0, sizeof(wire));
	wire.target_system = context->source_system;
	wire.target_component = context->source_component;
	wire.param_index = index;
	wire.error = error;
	if (name != NULL) {
		memcpy(wire.param_id, name, name_length(name));
	}
	(void)mavlink_send(context, context->link, &kind, &wire);
}

/* Another component may have what is asked of all. */
static void refuse_unknown(struct mavlink_params *self, const struct mavlink_context *context,
                           uint8_t target_component, const char *name, int16_t index)
{
	self->stats.unknown++;
	if (target_component == context->component->id) {
		refuse(context, name, index, MAV_PARAM_ERROR_DOES_NOT_EXIST);
	}
}

/* --- requests -------------------------------------------------------------------------------- */

void mavlink_params_request_read(const struct mavlink_context *context,
                                 const struct mavlink_frame *frame)
{
	struct mavlink_params *const self = params_of(context);
	mavlink_param_request_read_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));

	const bool by_name = wire.param_index == BY_NAME;
	const uint32_t index = by_name ? find(self, wire.param_id)
	                               : at_place(self->share, (uint16_t)wire.param_index);

	if (index < PARAM_COUNT) {
		answer(self, context, index);
	} else {
		refuse_unknown(self, context, wire.target_component, by_name ? wire.param_id : NULL,
		               wire.param_index);
	}
}

/* Something waits on a link: look again now. */
static void wake(struct mavlink_params *self, int64_t now_us)
{
	self->due_us = now_us < self->due_us ? now_us : self->due_us;
}

void mavlink_params_request_list(const struct mavlink_context *context,
                                 const struct mavlink_frame *frame)
{
	struct mavlink_params *const self = params_of(context);

	(void)frame;
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (mavlink_params_is(self->share, i)) {
			param_set_add(&self->waiting[context->link], i);
		}
	}
	wake(self, context->now_us);
}

/* --- sets ------------------------------------------------------------------------------------ */

/* An integer of the type in the four bytes of a PARAM_SET; false: no such type. */
static bool integer_of(uint8_t type, uint32_t bits, int64_t *number)
{
	switch (type) {
	case MAV_PARAM_TYPE_UINT8:
		*number = (uint8_t)bits;
		return true;
	case MAV_PARAM_TYPE_INT8:
		*number = (int8_t)bits;
		return true;
	case MAV_PARAM_TYPE_UINT16:
		*number = (uint16_t)bits;
		return true;
	case MAV_PARAM_TYPE_INT16:
		*number = (int16_t)bits;
		return true;
	case MAV_PARAM_TYPE_UINT32:
		*number = bits;
		return true;
	case MAV_PARAM_TYPE_INT32:
		*number = (int32_t)bits;
		return true;
	default: /* any number may come over the wire */
		return false;
	}
}

/* What a PARAM_SET means. MAV_PARAM_ERROR_NO_ERROR, or why it means nothing. */
static uint8_t value_of(const mavlink_param_set_t *wire, const struct param_info *info,
                        int32_t *value)
{
	uint32_t bits;
	int64_t number;
	bool fits;

	memcpy(&bits, &wire->param_value, sizeof(bits));
	if (wire->param_type == MAV_PARAM_TYPE_REAL32) {
		fits = param_from_real(info, bits, value);
	} else if (integer_of(wire->param_type, bits, &number)) {
		fits = param_from_integer(info, number, value);
	} else {
		return MAV_PARAM_ERROR_TYPE_UNSUPPORTED;
	}
	return fits ? MAV_PARAM_ERROR_NO_ERROR : MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE;
}

static uint8_t error_of(enum params_result result)
{
	switch (result) {
	case PARAMS_OK:
		return MAV_PARAM_ERROR_NO_ERROR;
	case PARAMS_UNKNOWN:
		return MAV_PARAM_ERROR_DOES_NOT_EXIST;
	case PARAMS_READ_ONLY:
		return MAV_PARAM_ERROR_READ_ONLY;
	case PARAMS_OUT_OF_RANGE:
	case PARAMS_CONFLICT:
		return MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE;
	case PARAMS_FORBIDDEN:
		break;
	}
	return MAV_PARAM_ERROR_PERMISSION_DENIED;
}

/* MAV_PARAM_ERROR. */
static uint8_t set(struct mavlink_params *self, const struct mavlink_context *context,
                   uint32_t index, int32_t value)
{
	const struct device_who who = mavlink_who(context);
	const int32_t before = self->device->params.values[index];
	const enum params_result result =
		pharos_device_set_param(self->device, context->now_us, &who, index, value);

	self->answered =
		self->device->params.values[index] != before ? index : (uint32_t)PARAM_COUNT;
	self->answered_link = context->link;
	return error_of(result);
}

void mavlink_params_set(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	struct mavlink_params *const self = params_of(context);
	mavlink_param_set_t wire;
	int32_t value;

	mavlink_frame_payload(frame, &wire, sizeof(wire));
	self->stats.sets++;

	const uint32_t index = find(self, wire.param_id);
	uint8_t error;

	if (index == PARAM_COUNT) {
		self->stats.refused++;
		refuse_unknown(self, context, wire.target_component, wire.param_id, BY_NAME);
		return;
	}
	error = value_of(&wire, params_info(index), &value);
	if (error == MAV_PARAM_ERROR_NO_ERROR) {
		error = set(self, context, index, value);
	}
	if (error != MAV_PARAM_ERROR_NO_ERROR) {
		self->stats.refused++;
		refuse(context, wire.param_id, BY_NAME, error);
	}
	answer(self, context, index);
}

/* --- what goes out by itself ----------------------------------------------------------------- */

void mavlink_params_changed(struct mavlink_params *self, int64_t now_us, uint8_t links,
                            const struct param_set *changed)
{
	struct param_set own = *changed;

	if (param_set_is_empty(changed)) {
		return; /* as after nearly every command */
	}
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (!mavlink_params_is(self->share, i)) {
			param_set_remove(&own, i);
		}
	}
	if (param_set_is_empty(&own)) {
		return;
	}
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		if ((links & 1u << link) != 0) {
			param_set_merge(&self->waiting[link], &own);
		}
	}
	wake(self, now_us);
}

void mavlink_params_tell(struct mavlink_params *self, const struct mavlink_context *context,
                         const struct param_set *changed)
{
	const uint8_t links = context->endpoint->config.links;
	const uint8_t answered = (uint8_t)(1u << self->answered_link);
	struct param_set news = *changed;

	if (self->answered == PARAM_COUNT) {
		mavlink_params_changed(self, context->now_us, links, changed);
		return;
	}
	mavlink_params_changed(self, context->now_us, links & (uint8_t)~answered, changed);
	param_set_remove(&news, self->answered);
	mavlink_params_changed(self, context->now_us, links & answered, &news);
	self->answered = PARAM_COUNT;
}

/* Takes turns from where it stopped, so that repeated requests hold no value back. */
static uint32_t take_next(struct mavlink_params *self, uint8_t link)
{
	struct param_set *const waiting = &self->waiting[link];

	for (uint32_t tried = 0; tried < PARAM_COUNT; tried++) {
		const uint32_t index = (self->next[link] + tried) % PARAM_COUNT;

		if (param_set_has(waiting, index)) {
			param_set_remove(waiting, index);
			self->next[link] =
				param_set_is_empty(waiting) ? 0 : (index + 1) % PARAM_COUNT;
			return index;
		}
	}
	return PARAM_COUNT;
}

static void send_next(struct mavlink_params *self, const struct mavlink_context *context,
                      uint8_t link)
{
	mavlink_param_value_t wire;

	fill_value(self, take_next(self, link), &wire);
	(void)mavlink_send_bulk(context, link, &value_kind, &wire);
}

bool mavlink_params_step(struct mavlink_params *self, const struct mavlink_context *context)
{
	const struct mavlink_endpoint *const endpoint = context->endpoint;
	int64_t due_us = TIME_NEVER_US;

	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		if ((endpoint->config.links & 1u << link) == 0) {
			self->waiting[link] = (struct param_set){0}; /* nobody is there any more */
			self->next[link] = 0;
		}
		while (!param_set_is_empty(&self->waiting[link]) &&
		       mavlink_bulk_due_us(endpoint, link) <= context->now_us) {
			if (!mavlink_outbox_has_room(context->out)) {
				return false;
			}
			send_next(self, context, link);
		}
		if (!param_set_is_empty(&self->waiting[link]) &&
		    mavlink_bulk_due_us(endpoint, link) < due_us) {
			due_us = mavlink_bulk_due_us(endpoint, link);
		}
	}
	self->due_us = due_us;
	return true;
}

int64_t mavlink_params_deadline_us(const struct mavlink_params *self)
{
	return self->due_us;
}
