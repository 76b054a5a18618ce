/* SPDX-License-Identifier: Apache-2.0 */
#include "core/program.h"

#include "core/assert.h"

/* Units of lit, dark, lit, … ; a last dark of 0 is what is left of the cycle. */
static const uint8_t one_flash[] = {1, 0};
static const uint8_t two_flashes[] = {1, 1, 1, 0};
static const uint8_t sos[] = {
	1, 1, 1, 1, 1, 3, /* S */
	3, 1, 3, 1, 3, 3, /* O */
	1, 1, 1, 1, 1, 7, /* S, and the space between words */
};
#define SOS_UNITS 34u

static bool in_range(uint64_t us)
{
	return us >= 1 && us <= STROBE_PERIOD_CEILING_US;
}

bool program_valid(const struct program *self)
{
	const uint64_t unit_us = self->unit_us;

	switch (self->kind) {
	case PROGRAM_NONE:
		return true;
	case PROGRAM_ANTI_COLLISION:
		return in_range(self->period_us) && unit_us >= 1 && unit_us < self->period_us;
	case PROGRAM_DOUBLE_FLASH:
		return in_range(self->period_us) && unit_us >= 1 && 3 * unit_us < self->period_us;
	case PROGRAM_FADE:
		return in_range(self->period_us) && self->period_us >= 2 * PROGRAM_FADE_STEP_US;
	case PROGRAM_SOS:
		return in_range(SOS_UNITS * unit_us);
	}
	return false;
}

bool program_equal(const struct program *a, const struct program *b)
{
	return a->kind == b->kind && a->period_us == b->period_us && a->unit_us == b->unit_us;
}

uint32_t program_period_us(const struct program *self)
{
	PHAROS_ASSERT(program_valid(self) && self->kind != PROGRAM_NONE);
	return self->kind == PROGRAM_SOS ? SOS_UNITS * self->unit_us : self->period_us;
}

/* Which part of the cycle at_us is in: lit for the even ones. *end_us: where that part ends. */
static bool flash_at(const struct program *self, const uint8_t *units, size_t count, uint32_t at_us,
                     uint32_t *end_us)
{
	*end_us = 0;
	for (size_t i = 0; i < count; i++) {
		*end_us = units[i] == 0 ? program_period_us(self)
		                        : *end_us + units[i] * self->unit_us;
		if (at_us < *end_us) {
			return i % 2 == 0;
		}
	}
	PHAROS_ASSERT(false);
	return false;
}

/*
 * A triangle of the step's middle, squared: eyes see light about as its root, so this looks even.
 */
static uint32_t fade_at(const struct program *self, uint32_t at_us, uint32_t *end_us)
{
	const uint32_t begin_us = at_us - at_us % PROGRAM_FADE_STEP_US;
	const uint32_t rest_us = self->period_us - begin_us;
	const uint32_t step_us = rest_us < PROGRAM_FADE_STEP_US ? rest_us : PROGRAM_FADE_STEP_US;
	const uint32_t middle_us = begin_us + step_us / 2;
	const uint32_t up_us =
		middle_us < self->period_us - middle_us ? middle_us : self->period_us - middle_us;
	const uint64_t height_ppm = (uint64_t)up_us * 2 * PPM_ONE / self->period_us;

	*end_us = begin_us + step_us;
	return (uint32_t)(height_ppm * height_ppm / PPM_ONE);
}

static uint32_t scale_at(const struct program *self, uint32_t at_us, uint32_t *end_us)
{
	bool lit = false;

	switch (self->kind) {
	case PROGRAM_NONE:
		PHAROS_ASSERT(false);
		break;
	case PROGRAM_ANTI_COLLISION:
		lit = flash_at(self, one_flash, sizeof(one_flash), at_us, end_us);
		break;
	case PROGRAM_DOUBLE_FLASH:
		lit = flash_at(self, two_flashes, sizeof(two_flashes), at_us, end_us);
		break;
	case PROGRAM_FADE:
		return fade_at(self, at_us, end_us);
	case PROGRAM_SOS:
		lit = flash_at(self, sos, sizeof(sos), at_us, end_us);
		break;
	}
	return lit ? PPM_ONE : 0;
}

struct program_phase program_at(const struct program *self, int64_t elapsed_us)
{
	PHAROS_ASSERT(elapsed_us >= 0 && elapsed_us <= TIME_MAX_US);

	const uint32_t period_us = program_period_us(self);
	const int64_t begin_us = elapsed_us - elapsed_us % period_us;
	uint32_t end_us = 0;
	const uint32_t scale_ppm = scale_at(self, (uint32_t)(elapsed_us - begin_us), &end_us);

	return (struct program_phase){.scale_ppm = scale_ppm, .until_us = begin_us + end_us};
}

static const char *const names[PROGRAM_KINDS] = {
	[PROGRAM_NONE] = "none",
	[PROGRAM_ANTI_COLLISION] = "anti-collision",
	[PROGRAM_DOUBLE_FLASH] = "double-flash",
	[PROGRAM_FADE] = "fade",
	[PROGRAM_SOS] = "sos",
};

const char *program_name(enum program_kind kind)
{
	PHAROS_ASSERT((uint32_t)kind < PROGRAM_KINDS);
	return names[kind];
}
