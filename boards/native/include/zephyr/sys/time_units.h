/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Conversions between units of time: k_<from>_to_<to>_<rounding><bits>(), for ms, us, ns, cyc,
 * ticks; floor, near, ceil; 32 and 64. Exact where the result fits.
 */
#ifndef ZEPHYR_SYS_TIME_UNITS_H_
#define ZEPHYR_SYS_TIME_UNITS_H_

#include <stdint.h>

#include <zephyr/toolchain.h>

#define MSEC_PER_SEC  1000U
#define USEC_PER_MSEC 1000U
#define NSEC_PER_USEC 1000U
#define NSEC_PER_MSEC 1000000U
#define USEC_PER_SEC  ((USEC_PER_MSEC) * (MSEC_PER_SEC))
#define NSEC_PER_SEC  ((NSEC_PER_USEC) * (USEC_PER_MSEC) * (MSEC_PER_SEC))

#define SYS_FOREVER_MS (-1)
#define SYS_FOREVER_US (-1)

/* Cycles of the simulated CPU are nanoseconds. */
#define NATIVE_CYCLES_PER_SEC 1000000000U

static inline int sys_clock_hw_cycles_per_sec(void)
{
	return (int)NATIVE_CYCLES_PER_SEC;
}

enum native_rounding {
	NATIVE_ROUND_FLOOR,
	NATIVE_ROUND_NEAR,
	NATIVE_ROUND_CEIL
};

/* value * to_hz / from_hz without overflow in between; folds to one operation for constant rates.
 */
static ALWAYS_INLINE uint64_t native_time_convert(uint64_t value, uint32_t from_hz, uint32_t to_hz,
                                                  enum native_rounding rounding)
{
	if (to_hz % from_hz == 0) {
		return value * (to_hz / from_hz);
	}

	const uint64_t whole = value / from_hz;
	const uint64_t rest = (value % from_hz) * to_hz;
	const uint64_t offset = rounding == NATIVE_ROUND_CEIL   ? from_hz - 1U
	                        : rounding == NATIVE_ROUND_NEAR ? from_hz / 2U
	                                                        : 0U;

	return whole * to_hz + (rest + offset) / from_hz;
}

#define NATIVE_HZ_ms    1000U
#define NATIVE_HZ_us    1000000U
#define NATIVE_HZ_ns    1000000000U
#define NATIVE_HZ_cyc   NATIVE_CYCLES_PER_SEC
#define NATIVE_HZ_ticks CONFIG_SYS_CLOCK_TICKS_PER_SEC

#define NATIVE_TIME_FN(from, to, mode, MODE)                                                       \
	static ALWAYS_INLINE uint32_t k_##from##_to_##to##_##mode##32(uint32_t t)                  \
	{                                                                                          \
		return (uint32_t)native_time_convert(t, NATIVE_HZ_##from, NATIVE_HZ_##to,          \
		                                     NATIVE_ROUND_##MODE);                         \
	}                                                                                          \
	static ALWAYS_INLINE uint64_t k_##from##_to_##to##_##mode##64(uint64_t t)                  \
	{                                                                                          \
		return native_time_convert(t, NATIVE_HZ_##from, NATIVE_HZ_##to,                    \
		                           NATIVE_ROUND_##MODE);                                   \
	}

#define NATIVE_TIME_FNS(from, to)                                                                  \
	NATIVE_TIME_FN(from, to, floor, FLOOR)                                                     \
	NATIVE_TIME_FN(from, to, near, NEAR)                                                       \
	NATIVE_TIME_FN(from, to, ceil, CEIL)

NATIVE_TIME_FNS(ms, cyc)
NATIVE_TIME_FNS(ms, ticks)
NATIVE_TIME_FNS(us, cyc)
NATIVE_TIME_FNS(us, ticks)
NATIVE_TIME_FNS(ns, cyc)
NATIVE_TIME_FNS(ns, ticks)
NATIVE_TIME_FNS(cyc, ms)
NATIVE_TIME_FNS(cyc, us)
NATIVE_TIME_FNS(cyc, ns)
NATIVE_TIME_FNS(cyc, ticks)
NATIVE_TIME_FNS(ticks, ms)
NATIVE_TIME_FNS(ticks, us)
NATIVE_TIME_FNS(ticks, ns)
NATIVE_TIME_FNS(ticks, cyc)

#endif
