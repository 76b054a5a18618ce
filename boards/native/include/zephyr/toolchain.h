/* SPDX-License-Identifier: Apache-2.0 */
/* Compiler attributes under Zephyr's names; gcc and clang. */
#ifndef ZEPHYR_TOOLCHAIN_H_
#define ZEPHYR_TOOLCHAIN_H_

#define BUILD_ASSERT(expr, ...) _Static_assert(expr, "" __VA_ARGS__)

#define ALWAYS_INLINE          inline __attribute__((always_inline))
#define FUNC_NORETURN          __attribute__((noreturn))
#define CODE_UNREACHABLE       __builtin_unreachable()
#define __aligned(x)           __attribute__((aligned(x)))
#define __packed               __attribute__((packed))
#define __weak                 __attribute__((weak))
#define __unused               __attribute__((unused))
#define __maybe_unused         __attribute__((unused))
#define __used                 __attribute__((used))
#define __printf_like(fmt, va) __attribute__((format(printf, fmt, va)))
#define __deprecated           __attribute__((deprecated))
#define __fallthrough          __attribute__((fallthrough))
/* Kept over a reset, lost with power: host/reset.c carries it. */
#define __noinit               __attribute__((section("native_noinit")))
#define __in_section_unique(seg)

#define ARG_UNUSED(x) ((void)(x))

#define likely(x)   (__builtin_expect(!!(x), 1) != 0)
#define unlikely(x) (__builtin_expect(!!(x), 0) != 0)

#define popcount(x) __builtin_popcount(x)

#define compiler_barrier() __asm__ volatile("" ::: "memory")

#define _STRINGIFY(x)    #x
#define STRINGIFY(s)     _STRINGIFY(s)
#define _DO_CONCAT(x, y) x##y
#define _CONCAT(x, y)    _DO_CONCAT(x, y)
#define UNALIGNED_GET(p)                                                                           \
	__extension__({                                                                            \
		struct __packed {                                                                  \
			__typeof__(*(p)) value;                                                    \
		} *packed_p = (__typeof__(packed_p))(p);                                           \
		packed_p->value;                                                                   \
	})
#define UNALIGNED_PUT(v, p)                                                                        \
	do {                                                                                       \
		struct __packed {                                                                  \
			__typeof__(*(p)) value;                                                    \
		} *packed_p = (__typeof__(packed_p))(p);                                           \
		packed_p->value = (v);                                                             \
	} while (0)

#endif
