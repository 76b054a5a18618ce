/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Values of parameters as people read them: °C, %, s, deg. The one place where they become the
 * core's integers and back, for every protocol, the shell and the documents' texts:
 *
 *   core 80500  --- / 10^decimals --->  80.5 degC   THR_THROTTLE, 3 decimals
 *
 * A number between two steps becomes the nearer one. Where there is no unit (a choice, an id, a
 * count) a fraction is none: refused. What no int32_t holds is refused too; ranges are params_set's
 * business. Within a parameter's range core → binary32 → core, and by text, changes nothing.
 *
 * A binary32 is given by its bits, and nothing here needs floating-point arithmetic: exact on every
 * processor. False: refused, *value unchanged. Any context; no state.
 */
#ifndef PHAROS_CORE_PARAM_UNITS_H
#define PHAROS_CORE_PARAM_UNITS_H

#include "core/decimal.h"
#include "core/params.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The nearest binary32, ties to even; value within the parameter's range. */
uint32_t param_to_real(const struct param_info *info, int32_t value);
bool param_from_real(const struct param_info *info, uint32_t real, int32_t *value);

/* number of the unit people use: 80 for 80 degC. */
bool param_from_integer(const struct param_info *info, int64_t number, int32_t *value);

/* As decimal.h. */
size_t param_print(const struct param_info *info, int32_t value, char text[DECIMAL_TEXT_MAX]);
bool param_parse(const struct param_info *info, const char *text, size_t length, int32_t *value);

#endif
