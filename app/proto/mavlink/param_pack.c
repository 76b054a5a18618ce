/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/param_pack.h"

#include "core/param_units.h"
#include "proto/mavlink/param_service.h"

#include <string.h>

#define MAGIC               0x671Bu
#define MAGIC_WITH_DEFAULTS 0x671Cu
/* AP_PARAM_FLOAT */
#define TYPE_FLOAT          4u
#define FLAG_DEFAULT        0x10u
/* Each of the two lengths of a name has 4 bits; a rest is never empty. */
#define SHARED_MAX          15u

_Static_assert(PARAMS_NAME_MAX <= SHARED_MAX + 1, "the rest of a name fits");

void mavlink_param_pack_take(struct mavlink_param_pack *self, const struct params *params)
{
	memcpy(self->values, params->values, sizeof(self->values));
}

struct param_set mavlink_param_pack_outdated(const struct mavlink_param_pack *self,
                                             const struct params *params)
{
	struct param_set outdated = {0};

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (mavlink_params_is(MAVLINK_PARAMS_LIGHT, i) &&
		    self->values[i] != params->values[i]) {
			param_set_add(&outdated, i);
		}
	}
	return outdated;
}

/* The file goes by; what lies between begin and end is kept. */
struct window {
	uint32_t at;
	uint32_t begin;
	uint32_t end;
	uint8_t *to;
};

static void put_byte(struct window *window, uint8_t byte)
{
	if (window->at >= window->begin && window->at < window->end) {
		window->to[window->at - window->begin] = byte;
	}
	window->at++;
}

static void put(struct window *window, uint32_t value, uint8_t bytes)
{
	for (uint8_t i = 0; i < bytes; i++) {
		put_byte(window, (uint8_t)(value >> (8 * i)));
	}
}

/* Something is left of a name even if the name before begins with it. */
static uint8_t shared_length(const char *before, const char *name)
{
	uint8_t length = 0;

	while (length < SHARED_MAX && before[length] == name[length] && name[length + 1] != '\0') {
		length++;
	}
	return length;
}

static void put_param(struct window *window, const char *before, uint32_t index, int32_t value,
                      bool with_defaults)
{
	const struct param_info *const info = params_info(index);
	const bool has_default = with_defaults && value != info->fallback;
	const uint8_t shared = shared_length(before, info->name);
	const uint8_t rest = (uint8_t)(strlen(info->name) - shared);

	put_byte(window, (uint8_t)(TYPE_FLOAT | (has_default ? FLAG_DEFAULT : 0)));
	put_byte(window, (uint8_t)(shared | (rest - 1) << 4));
	for (uint8_t i = 0; i < rest; i++) {
		put_byte(window, (uint8_t)info->name[shared + i]);
	}
	put(window, param_to_real(info, value), sizeof(float));
	if (has_default) {
		put(window, param_to_real(info, info->fallback), sizeof(float));
	}
}

/* Returns the length of the file. */
static uint32_t pass(const struct mavlink_param_pack *self, bool with_defaults,
                     struct window *window)
{
	const uint16_t count = mavlink_params_count(MAVLINK_PARAMS_LIGHT);
	const char *before = "";

	put(window, with_defaults ? MAGIC_WITH_DEFAULTS : MAGIC, 2);
	put(window, count, 2);
	put(window, count, 2);
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (mavlink_params_is(MAVLINK_PARAMS_LIGHT, i)) {
			put_param(window, before, i, self->values[i], with_defaults);
			before = params_info(i)->name;
		}
	}
	return window->at;
}

uint32_t mavlink_param_pack_length(const struct mavlink_param_pack *self, bool with_defaults)
{
	struct window nothing = {0};

	return pass(self, with_defaults, &nothing);
}

void mavlink_param_pack_read(const struct mavlink_param_pack *self, bool with_defaults,
                             uint32_t offset, uint8_t count, uint8_t *to)
{
	struct window window = {.begin = offset, .end = offset + count, .to = to};

	(void)pass(self, with_defaults, &window);
}
