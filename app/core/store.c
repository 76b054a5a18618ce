/* SPDX-License-Identifier: Apache-2.0 */
#include "core/store.h"

#include <string.h>

#define VERSION 1

/* What is there. */
#define HAS_LIGHT   1u
#define HAS_POWER   2u
#define HAS_SIGNING 4u

#define AT_SEQUENCE 4
#define AT_VERSION  8
#define AT_THERE    9

#define LIGHT_BYTES 14

#define VARINT_MORE 0x80u
#define VARINT_MAX  5

static uint32_t crc32(const uint8_t *data, size_t length)
{
	uint32_t crc = UINT32_MAX;

	for (size_t i = 0; i < length; i++) {
		crc ^= data[i];
		for (int bit = 0; bit < 8; bit++) {
			crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
		}
	}
	return ~crc;
}

/* A name's, as the header has it. */
static uint16_t key_of(const char *name)
{
	uint32_t hash = 2166136261u;

	for (; *name != '\0'; name++) {
		hash = (hash ^ (uint8_t)*name) * 16777619u;
	}
	return (uint16_t)(hash ^ hash >> 16);
}

/* What version 0.1 called otherwise, or let reach further: up to before_max. */
struct former {
	const char *name;
	enum param_id id;
	int32_t before_max; /* 0: as today */
};

#define STROBE_BEFORE_US 60000000

static const struct former formers[] = {
	{"STRB_MIN_US", PARAM_STRB_MIN, STROBE_BEFORE_US},
	{"STRB_MAX_US", PARAM_STRB_MAX, STROBE_BEFORE_US},
	{"BCN_PERIOD_US", PARAM_BCN_PERIOD, STROBE_BEFORE_US},
	{"PRG_FLASH_MS", PARAM_PRG_FLASH, 0},
	{"PRG_FADE_MS", PARAM_PRG_FADE, 0},
	{"PRG_DOT_MS", PARAM_PRG_DOT, 0},
	{"LGT_LOSS_MS", PARAM_LGT_LOSS, 0},
	{"THR_STUCK_MS", PARAM_THR_STUCK, 0},
	{"THR_MISS_MS", PARAM_THR_MISS, 0},
	{"THR_FIRST_MS", PARAM_THR_FIRST, 0},
	{"SYNC_LOSS_MS", PARAM_SYNC_TMO, 0},
	{"SYNC_FILT_US", PARAM_SYNC_FILT, 0},
	{"SYNC_PULSE_US", PARAM_SYNC_PULSE, STROBE_BEFORE_US},
	{"THR_SLEW", PARAM_THR_SLEW, 1000000000},
#ifdef CONFIG_PHAROS_IMC
	{"ESC_MIN_US", PARAM_ESC_MIN, 0},
	{"ESC_MAX_US", PARAM_ESC_MAX, 0},
	{"ESC_ARM_MS", PARAM_ESC_ARM, 0},
	{"ESC_LOSS_MS", PARAM_ESC_LOSS, 0},
	{"ZOOM_TIME_MS", PARAM_ZOOM_TIME, 0},
	{"DOWN_TIME_S", PARAM_DOWN_TIME, 0},
#endif
#ifdef CONFIG_PHAROS_GIMBAL
	{"GMB_RATE_MS", PARAM_GMB_RATE_TMO, 0},
	{"GMB_ATT_MS", PARAM_GMB_ATT_TMO, 0},
#endif
};
#define FORMERS (sizeof(formers) / sizeof(formers[0]))

static const struct former *former_of(uint32_t index)
{
	for (size_t i = 0; i < FORMERS; i++) {
		if (formers[i].id == index) {
			return &formers[i];
		}
	}
	return NULL;
}

const char *store_former_name(uint32_t index)
{
	const struct former *const former = former_of(index);

	return former == NULL ? NULL : former->name;
}

/* The parameter that has the key, or had it; PARAM_COUNT: none. */
static uint32_t index_of(uint16_t key)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (key_of(params_info(i)->name) == key) {
			return i;
		}
	}
	for (size_t i = 0; i < FORMERS; i++) {
		if (key_of(formers[i].name) == key) {
			return formers[i].id;
		}
	}
	return PARAM_COUNT;
}

uint32_t store_find(const char *name)
{
	return index_of(key_of(name));
}

void store_put(struct store *self, uint32_t index, int32_t value)
{
	const struct former *const former = former_of(index);
	const int32_t max = params_info(index)->max;
	const bool reached_further = former != NULL && value <= former->before_max;

	self->state.params.values[index] = reached_further && value > max ? max : value;
}

/* --- writing a record ------------------------------------------------------------------------- */

struct writer {
	uint8_t *bytes;
	size_t length;
};

static void put(struct writer *writer, uint32_t value, size_t bytes)
{
	for (size_t i = 0; i < bytes; i++) {
		writer->bytes[writer->length++] = (uint8_t)(value >> 8 * i);
	}
}

static void put_param(struct writer *writer, const struct param_info *info, int32_t value)
{
	uint32_t zigzag = (uint32_t)value << 1 ^ (value < 0 ? UINT32_MAX : 0);

	put(writer, key_of(info->name), 2);
	for (; zigzag >= VARINT_MORE; zigzag >>= 7) {
		put(writer, zigzag | VARINT_MORE, 1);
	}
	put(writer, zigzag, 1);
}

static size_t encode(const struct store_state *state, uint32_t sequence, uint8_t *record)
{
	struct writer writer = {.bytes = record, .length = AT_SEQUENCE};

	put(&writer, sequence, 4);
	put(&writer, VERSION, 1);
	put(&writer,
	    (state->has_light ? HAS_LIGHT : 0) | (state->has_power ? HAS_POWER : 0) |
	            (state->has_signing ? HAS_SIGNING : 0),
	    1);
	if (state->has_light) {
		put(&writer, state->light.brightness_ppm, 4);
		put(&writer, state->light.strobe_period_us, 4);
		put(&writer, state->light.duty_ppm, 4);
		put(&writer, state->light.mode, 1);
		put(&writer, state->light.enable, 1);
	}
	if (state->has_power) {
		put(&writer, state->power, 1);
	}
	if (state->has_signing) {
		memcpy(&record[writer.length], state->signing, STORE_SIGNING_BYTES);
		writer.length += STORE_SIGNING_BYTES;
	}
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *const info = params_info(i);

		if ((info->flags & PARAM_FLAG_READ_ONLY) == 0 &&
		    state->params.values[i] != info->fallback) {
			put_param(&writer, info, state->params.values[i]);
		}
	}
	const size_t length = writer.length;

	writer.length = 0;
	put(&writer, crc32(&record[AT_SEQUENCE], length - AT_SEQUENCE), 4);
	return length;
}

/* --- reading one ------------------------------------------------------------------------------ */

struct reader {
	const uint8_t *bytes;
	size_t left;
	bool short_of; /* it ended too early */
};

static const uint8_t *take(struct reader *reader, size_t bytes)
{
	static const uint8_t none[STORE_SIGNING_BYTES];
	const uint8_t *const at = reader->bytes;

	if (bytes > reader->left) {
		reader->short_of = true;
		reader->left = 0;
		return none;
	}
	reader->bytes += bytes;
	reader->left -= bytes;
	return at;
}

static uint32_t get(struct reader *reader, size_t bytes)
{
	const uint8_t *const at = take(reader, bytes);
	uint32_t value = 0;

	for (size_t i = 0; i < bytes; i++) {
		value |= (uint32_t)at[i] << 8 * i;
	}
	return value;
}

static int32_t get_value(struct reader *reader)
{
	uint32_t zigzag = 0;
	uint32_t byte = VARINT_MORE;

	for (size_t i = 0; i < VARINT_MAX && (byte & VARINT_MORE) != 0; i++) {
		byte = get(reader, 1);
		zigzag |= (byte & ~VARINT_MORE) << 7 * i;
	}
	return (int32_t)(zigzag >> 1 ^ ((zigzag & 1) != 0 ? UINT32_MAX : 0));
}

/* The next parameter of the table; PARAM_COUNT: none is left. */
static uint32_t next_param(struct reader *reader, int32_t *value)
{
	while (reader->left > 0) {
		const uint16_t key = (uint16_t)get(reader, 2);

		*value = get_value(reader);
		const uint32_t index = reader->short_of ? (uint32_t)PARAM_COUNT : index_of(key);

		if (index < PARAM_COUNT) {
			return index;
		}
	}
	return PARAM_COUNT;
}

/* What a record has before its parameters. */
static void read_rest(struct reader *reader, uint8_t there, struct store_state *state)
{
	state->has_light = (there & HAS_LIGHT) != 0;
	state->has_power = (there & HAS_POWER) != 0;
	state->has_signing = (there & HAS_SIGNING) != 0;
	if (state->has_light) {
		state->light.brightness_ppm = get(reader, 4);
		state->light.strobe_period_us = get(reader, 4);
		state->light.duty_ppm = get(reader, 4);
		state->light.mode = (enum illuminator_mode)get(reader, 1);
		state->light.enable = get(reader, 1) != 0;
	}
	if (state->has_power) {
		state->power = (uint8_t)get(reader, 1);
	}
	if (state->has_signing) {
		memcpy(state->signing, take(reader, STORE_SIGNING_BYTES), STORE_SIGNING_BYTES);
	}
}

static void skip_rest(struct reader *reader, uint8_t there)
{
	(void)take(reader, (there & HAS_LIGHT) != 0 ? LIGHT_BYTES : 0);
	(void)take(reader, (there & HAS_POWER) != 0 ? 1 : 0);
	(void)take(reader, (there & HAS_SIGNING) != 0 ? STORE_SIGNING_BYTES : 0);
}

static bool is_whole(const uint8_t *record, size_t length)
{
	struct reader reader = {.bytes = record, .left = length};

	return length >= STORE_RECORD_MIN && record[AT_VERSION] == VERSION &&
	       get(&reader, 4) == crc32(&record[AT_SEQUENCE], length - AT_SEQUENCE);
}

bool store_offer(struct store *self, uint8_t slot, const uint8_t *record, size_t length)
{
	struct reader reader = {.bytes = record, .left = length};
	int32_t value;

	if (!is_whole(record, length)) {
		return false;
	}
	(void)take(&reader, AT_SEQUENCE);

	const uint32_t sequence = get(&reader, 4);

	if (sequence > self->sequence) {
		(void)take(&reader, 2);
		store_init(self);
		self->sequence = sequence;
		self->slot = (uint8_t)((slot + 1) % STORE_SLOTS);
		read_rest(&reader, record[AT_THERE], &self->state);
		for (uint32_t i = next_param(&reader, &value); i < PARAM_COUNT;
		     i = next_param(&reader, &value)) {
			store_put(self, i, value);
		}
	}
	return true;
}

void store_salvage(struct store *self, const uint8_t *record, size_t length)
{
	struct reader reader = {.bytes = record, .left = length};
	int32_t value;

	(void)take(&reader, AT_THERE);
	skip_rest(&reader, (uint8_t)get(&reader, 1));
	for (uint32_t i = next_param(&reader, &value); i < PARAM_COUNT;
	     i = next_param(&reader, &value)) {
		if (params_is_heat_limit(i) && value < self->state.params.values[i]) {
			self->state.params.values[i] = value;
		}
	}
}

struct param_set store_check(struct store *self)
{
	return params_load(&self->state.params, self->state.params.values);
}

void store_init(struct store *self)
{
	memset(self, 0, sizeof(*self));
	params_init(&self->state.params);
	self->due_us = TIME_NEVER_US;
}

/* --- what is accepted ------------------------------------------------------------------------- */

void store_touch(struct store *self, int64_t now_us)
{
	self->due_us = now_us;
}

void store_params(struct store *self, int64_t now_us, const struct params *params,
                  const struct param_set *changed)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (param_set_has(changed, i) &&
		    self->state.params.values[i] != params->values[i]) {
			self->state.params.values[i] = params->values[i];
			store_touch(self, now_us);
		}
	}
}

static bool is_same_light(const struct illuminator_settings *a,
                          const struct illuminator_settings *b)
{
	return a->enable == b->enable && a->mode == b->mode &&
	       a->brightness_ppm == b->brightness_ppm &&
	       a->strobe_period_us == b->strobe_period_us && a->duty_ppm == b->duty_ppm;
}

void store_light(struct store *self, int64_t now_us, const struct illuminator_settings *light)
{
	if (!self->state.has_light || !is_same_light(&self->state.light, light)) {
		self->state.has_light = true;
		self->state.light = *light;
		settle_change(&self->light, now_us);
	}
}

void store_power(struct store *self, int64_t now_us, uint8_t mask)
{
	if (self->state.power != mask) {
		self->state.has_power = true;
		self->state.power = mask;
		store_touch(self, now_us);
	}
}

void store_signing(struct store *self, int64_t now_us, const uint8_t record[STORE_SIGNING_BYTES])
{
	if (!self->state.has_signing ||
	    memcmp(self->state.signing, record, STORE_SIGNING_BYTES) != 0) {
		self->state.has_signing = true;
		memcpy(self->state.signing, record, STORE_SIGNING_BYTES);
		store_touch(self, now_us);
	}
}

/* --- writing ---------------------------------------------------------------------------------- */

int64_t store_deadline_us(const struct store *self)
{
	const int64_t light_us = settle_deadline_us(&self->light);

	return self->due_us < light_us ? self->due_us : light_us;
}

size_t store_begin(struct store *self, int64_t now_us, uint8_t *record, uint8_t *slot)
{
	if (store_deadline_us(self) > now_us) {
		return 0;
	}
	if (self->due_us <= now_us) {
		settle_drop(&self->light);
	} else {
		settle_write(&self->light, now_us);
	}
	/* What waited for another try goes along as well. */
	self->due_us = TIME_NEVER_US;
	*slot = self->slot;
	return encode(&self->state, self->sequence + 1, record);
}

void store_done(struct store *self, int64_t now_us, bool stored)
{
	if (stored) {
		self->sequence++;
		self->slot = (uint8_t)((self->slot + 1) % STORE_SLOTS);
	} else if (self->due_us == TIME_NEVER_US) {
		self->due_us = now_us + STORE_RETRY_US;
	}
}
