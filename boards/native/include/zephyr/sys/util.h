/* SPDX-License-Identifier: Apache-2.0 */
/* Small helpers under Zephyr's names. MIN, MAX and CLAMP evaluate their arguments more than once.
 */
#ifndef ZEPHYR_SYS_UTIL_H_
#define ZEPHYR_SYS_UTIL_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/sys/util_macro.h>
#include <zephyr/toolchain.h>
#include <zephyr/types.h>

#define POINTER_TO_UINT(x) ((uintptr_t)(x))
#define UINT_TO_POINTER(x) ((void *)(uintptr_t)(x))
#define POINTER_TO_INT(x)  ((intptr_t)(x))
#define INT_TO_POINTER(x)  ((void *)(intptr_t)(x))

/* A build error for a pointer. */
#define IS_ARRAY(array)             (!__builtin_types_compatible_p(__typeof__(array), __typeof__(&(array)[0])))
#define ZERO_OR_COMPILE_ERROR(cond) ((int)sizeof(char[1 - 2 * !(cond)]) - 1)
#define ARRAY_SIZE(array)                                                                          \
	((size_t)ZERO_OR_COMPILE_ERROR(IS_ARRAY(array)) + (sizeof(array) / sizeof((array)[0])))
#define ARRAY_FOR_EACH(array, idx) for (size_t idx = 0; (idx) < ARRAY_SIZE(array); ++(idx))
#define IS_ARRAY_ELEMENT(array, ptr)                                                               \
	((ptr) && POINTER_TO_UINT(array) <= POINTER_TO_UINT(ptr) &&                                \
	 POINTER_TO_UINT(ptr) < POINTER_TO_UINT(&(array)[ARRAY_SIZE(array)]) &&                    \
	 (POINTER_TO_UINT(ptr) - POINTER_TO_UINT(array)) % sizeof((array)[0]) == 0)
#define ARRAY_INDEX(array, ptr) ((size_t)((__typeof__(&(array)[0]))(ptr) - (array)))

#define SAME_TYPE(a, b)            __builtin_types_compatible_p(__typeof__(a), __typeof__(b))
#define SIZEOF_FIELD(type, member) sizeof((((type *)0)->member))

#define CONTAINER_OF(ptr, type, field)                                                             \
	__extension__({                                                                            \
		_Static_assert(SAME_TYPE(*(ptr), ((type *)0)->field) || SAME_TYPE(*(ptr), void),   \
		               "pointer type mismatch in CONTAINER_OF");                           \
		((type *)(((char *)(ptr)) - offsetof(type, field)));                               \
	})

#define ROUND_UP(x, align)                                                                         \
	((((unsigned long)(x) + ((unsigned long)(align)-1)) / (unsigned long)(align)) *            \
	 (unsigned long)(align))
#define ROUND_DOWN(x, align)                                                                       \
	(((unsigned long)(x) / (unsigned long)(align)) * (unsigned long)(align))
#define WB_UP(x)               ROUND_UP(x, sizeof(void *))
#define WB_DN(x)               ROUND_DOWN(x, sizeof(void *))
#define DIV_ROUND_UP(n, d)     (((n) + (d)-1) / (d))
#define ceiling_fraction(n, d) DIV_ROUND_UP(n, d)

#ifndef MAX
#define MAX(a, b) (((a) > (b)) ? (a) : (b))
#endif
#ifndef MIN
#define MIN(a, b) (((a) < (b)) ? (a) : (b))
#endif
#ifndef CLAMP
#define CLAMP(val, low, high) (((val) <= (low)) ? (low) : MIN(val, high))
#endif
#define IN_RANGE(val, min, max) ((val) >= (min) && (val) <= (max))

/* Bits h…l set. */
#define GENMASK(h, l) (((~0UL) - (1UL << (l)) + 1) & (~0UL >> (sizeof(long) * 8 - 1 - (h))))

#define LSB_GET(value)          ((value) & -(value))
#define FIELD_GET(mask, value)  (((value) & (mask)) / LSB_GET(mask))
#define FIELD_PREP(mask, value) (((value)*LSB_GET(mask)) & (mask))

#define KB(x)  ((x) << 10)
#define MB(x)  (KB(x) << 10)
#define KHZ(x) ((x)*1000)
#define MHZ(x) (KHZ(x) * 1000)

static inline bool is_power_of_two(unsigned int x)
{
	return IS_POWER_OF_TWO(x);
}

static inline uint8_t bin2bcd(uint8_t bin)
{
	return (uint8_t)(((bin / 10) << 4) | (bin % 10));
}

static inline uint8_t bcd2bin(uint8_t bcd)
{
	return (uint8_t)((10 * (bcd >> 4)) + (bcd & 0x0F));
}

/* A hexadecimal digit's value; -EINVAL: not a digit. */
int char2hex(char c, uint8_t *x);
/* Bytes written; 0: the output is too small or the input is not hexadecimal. */
size_t hex2bin(const char *hex, size_t hexlen, uint8_t *buf, size_t buflen);

#endif
