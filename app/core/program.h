/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Light programs: a pattern that an enabled lamp shows, again and again, without anyone commanding
 * each flash.
 *
 * ANTI_COLLISION: one flash a cycle. DOUBLE_FLASH: two, a flash's length apart. FADE: up and down,
 * as breathing, in steps of PROGRAM_FADE_STEP_US. SOS: three short, three long, three short, in
 * dots: 1 short, 3 long, 1 apart, 3 between letters, 7 before it begins again.
 *
 * A pattern is a function of the time since it began, so nothing accumulates: cycle k begins
 * exactly k periods after the first. No state. Any context.
 * Spec: ITU-R M.1677-1 (Morse); 14 CFR 25.1401 (c), EASA CS-25.1401 (c): 40 to 100 flashes a
 * minute.
 */
#ifndef PHAROS_CORE_PROGRAM_H
#define PHAROS_CORE_PROGRAM_H

#include "core/limits.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROGRAM_FADE_STEP_US 20000u

enum program_kind {
	PROGRAM_NONE,
	PROGRAM_ANTI_COLLISION,
	PROGRAM_DOUBLE_FLASH,
	PROGRAM_FADE,
	PROGRAM_SOS,
};
#define PROGRAM_KINDS 5

/*
 * period_us: of a cycle; not looked at by SOS, whose cycle is 34 dots. unit_us: a flash, or a dot;
 * not looked at by FADE. For DOUBLE_FLASH 3 * unit_us < period_us, for ANTI_COLLISION unit_us <
 * period_us; both 1…STROBE_PERIOD_CEILING_US; all asserted. NONE: both 0.
 */
struct program {
	enum program_kind kind;
	uint32_t period_us;
	uint32_t unit_us;
};

/* What a program shows at a time: scale_ppm of the lamp's level, until then. */
struct program_phase {
	uint32_t scale_ppm;
	int64_t until_us; /* since the program began; beyond the time asked for */
};

bool program_valid(const struct program *self);
bool program_equal(const struct program *a, const struct program *b);

/* A cycle's length; the program is valid (asserted) and not NONE. */
uint32_t program_period_us(const struct program *self);

/* elapsed_us: since it began, 0…TIME_MAX_US. As program_period_us. */
struct program_phase program_at(const struct program *self, int64_t elapsed_us);

/* "none", "anti-collision", … ; constant and never NULL. */
const char *program_name(enum program_kind kind);

#endif
