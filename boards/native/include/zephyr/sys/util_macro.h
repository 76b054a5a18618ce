/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Preprocessor helpers under Zephyr's names: IS_ENABLED(), COND_CODE_1(), FOR_EACH(), LISTIFY() and
 * relatives. Families are written out up to 64 members; a use beyond that does not compile.
 */
#ifndef ZEPHYR_SYS_UTIL_MACRO_H_
#define ZEPHYR_SYS_UTIL_MACRO_H_

#define BIT(n)             (1UL << (n))
#define BIT64(n)           (1ULL << (n))
#define BIT_MASK(n)        (BIT(n) - 1UL)
#define BIT64_MASK(n)      (BIT64(n) - 1ULL)
#define IS_POWER_OF_TWO(x) (((x) != 0U) && (((x) & ((x)-1U)) == 0U))
#define IS_SHIFTED_BIT_MASK(m, s)                                                                  \
	(((m) != 0U) && (((m)&BIT_MASK(s)) == 0U) && ((((m) >> (s)) & (((m) >> (s)) + 1U)) == 0U))
#define IS_BIT_MASK(m)           IS_SHIFTED_BIT_MASK(m, 0)
#define BIT_IS_SET(value, bit)   ((((value) >> (bit)) & (0x1)) != 0)
#define WRITE_BIT(var, bit, set) ((var) = (set) ? ((var) | BIT(bit)) : ((var) & ~BIT(bit)))

/* 1 when the option is defined as 1, else 0; usable in #if, in if () and in macros. */
#define NATIVE_ONE_1                        native_one,
#define NATIVE_SECOND(ignored, second, ...) second
#define NATIVE_IS_ONE_3(one_or_junk)        NATIVE_SECOND(one_or_junk 1, 0, 0)
#define NATIVE_IS_ONE_2(value)              NATIVE_IS_ONE_3(NATIVE_ONE_##value)
#define IS_ENABLED(config)                  NATIVE_IS_ONE_2(config)

/* The code arguments are in parentheses, which are removed. */
#define NATIVE_DEBRACKET(...)               __VA_ARGS__
#define NATIVE_PICK_2(ignored, picked, ...) NATIVE_DEBRACKET picked
#define NATIVE_COND_3(one_or_junk, if_code, else_code)                                             \
	NATIVE_PICK_2(one_or_junk if_code, else_code, 0)
#define NATIVE_COND_1_2(flag, if_code, else_code)                                                  \
	NATIVE_COND_3(NATIVE_ONE_##flag, if_code, else_code)
#define NATIVE_ZERO_0 native_zero,
#define NATIVE_COND_0_2(flag, if_code, else_code)                                                  \
	NATIVE_COND_3(NATIVE_ZERO_##flag, if_code, else_code)
#define COND_CODE_1(flag, if_code, else_code) NATIVE_COND_1_2(flag, if_code, else_code)
#define COND_CODE_0(flag, if_code, else_code) NATIVE_COND_0_2(flag, if_code, else_code)
#define IF_ENABLED(flag, code)                COND_CODE_1(flag, code, ())

/* 1 when nothing is between the parentheses (a single argument that is a token or nothing). */
#define NATIVE_EMPTY_                    native_empty,
#define NATIVE_IS_EMPTY_3(empty_or_junk) NATIVE_SECOND(empty_or_junk 1, 0, 0)
#define NATIVE_IS_EMPTY_2(a)             NATIVE_IS_EMPTY_3(NATIVE_EMPTY_##a)
#define IS_EMPTY(a)                      NATIVE_IS_EMPTY_2(a)

#define EMPTY
#define IDENTITY(v)                       v
#define GET_ARG_N(n, ...)                 NATIVE_GET_ARG_##n(__VA_ARGS__)
#define NATIVE_GET_ARG_1(a, ...)          a
#define NATIVE_GET_ARG_2(a, b, ...)       b
#define NATIVE_GET_ARG_3(a, b, c, ...)    c
#define NATIVE_GET_ARG_4(a, b, c, d, ...) d
#define GET_ARGS_LESS_N(n, ...)           NATIVE_ARGS_LESS_##n(__VA_ARGS__)
#define NATIVE_ARGS_LESS_0(...)           __VA_ARGS__
#define NATIVE_ARGS_LESS_1(a, ...)        __VA_ARGS__
#define NATIVE_ARGS_LESS_2(a, b, ...)     __VA_ARGS__
#define NATIVE_ARGS_LESS_3(a, b, c, ...)  __VA_ARGS__

#define UTIL_CAT(a, ...)           UTIL_PRIMITIVE_CAT(a, __VA_ARGS__)
#define UTIL_PRIMITIVE_CAT(a, ...) a##__VA_ARGS__
#define UTIL_NOT(a)                COND_CODE_1(a, (0), (1))
#define UTIL_AND(a, b)             COND_CODE_1(a, (b), (0))
#define UTIL_OR(a, b)              COND_CODE_1(a, (1), (b))

#define NUM_VA_ARGS_LESS_1(...)                                                                    \
	NATIVE_COUNT(__VA_ARGS__, 63, 62, 61, 60, 59, 58, 57, 56, 55, 54, 53, 52, 51, 50, 49, 48,  \
	             47, 46, 45, 44, 43, 42, 41, 40, 39, 38, 37, 36, 35, 34, 33, 32, 31, 30, 29,   \
	             28, 27, 26, 25, 24, 23, 22, 21, 20, 19, 18, 17, 16, 15, 14, 13, 12, 11, 10,   \
	             9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 0)
#define NATIVE_COUNT(_0, _1, _2, _3, _4, _5, _6, _7, _8, _9, _10, _11, _12, _13, _14, _15, _16,    \
                     _17, _18, _19, _20, _21, _22, _23, _24, _25, _26, _27, _28, _29, _30, _31,    \
                     _32, _33, _34, _35, _36, _37, _38, _39, _40, _41, _42, _43, _44, _45, _46,    \
                     _47, _48, _49, _50, _51, _52, _53, _54, _55, _56, _57, _58, _59, _60, _61,    \
                     _62, _63, n, ...)                                                             \
	n
#define NATIVE_ARGS_(...)                                                                          \
	NATIVE_COUNT(__VA_ARGS__, 64, 63, 62, 61, 60, 59, 58, 57, 56, 55, 54, 53, 52, 51, 50, 49,  \
	             48, 47, 46, 45, 44, 43, 42, 41, 40, 39, 38, 37, 36, 35, 34, 33, 32, 31, 30,   \
	             29, 28, 27, 26, 25, 24, 23, 22, 21, 20, 19, 18, 17, 16, 15, 14, 13, 12, 11,   \
	             10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0)

/* FOR_EACH(F, (sep), x1, x2, …): F(x1) sep F(x2) …; _IDX: F(0, x1); _FIXED_ARG: F(x1, arg); no
 * arguments: nothing. */
#define NATIVE_FE_N(...)                 NATIVE_ARGS_(__VA_ARGS__)
#define NATIVE_CALL(n, ...)              NATIVE_CALL_2(n, __VA_ARGS__)
#define NATIVE_CALL_2(n, ...)            NATIVE_FE_##n(__VA_ARGS__)
#define NATIVE_W_PLAIN(F, arg, i, x)     F(x)
#define NATIVE_W_IDX(F, arg, i, x)       F(i, x)
#define NATIVE_W_FIXED(F, arg, i, x)     F(x, arg)
#define NATIVE_W_IDX_FIXED(F, arg, i, x) F(i, x, arg)
#define FOR_EACH(F, sep, ...)                                                                      \
	NATIVE_CALL(NATIVE_FE_N(__VA_ARGS__), NATIVE_W_PLAIN, F, sep, , __VA_ARGS__)
#define FOR_EACH_IDX(F, sep, ...)                                                                  \
	NATIVE_CALL(NATIVE_FE_N(__VA_ARGS__), NATIVE_W_IDX, F, sep, , __VA_ARGS__)
#define FOR_EACH_FIXED_ARG(F, sep, arg, ...)                                                       \
	NATIVE_CALL(NATIVE_FE_N(__VA_ARGS__), NATIVE_W_FIXED, F, sep, arg, __VA_ARGS__)
#define FOR_EACH_IDX_FIXED_ARG(F, sep, arg, ...)                                                   \
	NATIVE_CALL(NATIVE_FE_N(__VA_ARGS__), NATIVE_W_IDX_FIXED, F, sep, arg, __VA_ARGS__)

#define NATIVE_FE_1(W, F, sep, arg, x0) W(F, arg, 0, x0)
#define NATIVE_FE_2(W, F, sep, arg, x0, x1)                                                        \
	NATIVE_FE_1(W, F, sep, arg, x0) NATIVE_DEBRACKET sep W(F, arg, 1, x1)
#define NATIVE_FE_3(W, F, sep, arg, x0, x1, x2)                                                    \
	NATIVE_FE_2(W, F, sep, arg, x0, x1) NATIVE_DEBRACKET sep W(F, arg, 2, x2)
#define NATIVE_FE_4(W, F, sep, arg, x0, x1, x2, x3)                                                \
	NATIVE_FE_3(W, F, sep, arg, x0, x1, x2) NATIVE_DEBRACKET sep W(F, arg, 3, x3)
#define NATIVE_FE_5(W, F, sep, arg, x0, x1, x2, x3, x4)                                            \
	NATIVE_FE_4(W, F, sep, arg, x0, x1, x2, x3) NATIVE_DEBRACKET sep W(F, arg, 4, x4)
#define NATIVE_FE_6(W, F, sep, arg, x0, x1, x2, x3, x4, x5)                                        \
	NATIVE_FE_5(W, F, sep, arg, x0, x1, x2, x3, x4) NATIVE_DEBRACKET sep W(F, arg, 5, x5)
#define NATIVE_FE_7(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6)                                    \
	NATIVE_FE_6(W, F, sep, arg, x0, x1, x2, x3, x4, x5) NATIVE_DEBRACKET sep W(F, arg, 6, x6)
#define NATIVE_FE_8(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7)                                \
	NATIVE_FE_7(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6)                                    \
	NATIVE_DEBRACKET sep W(F, arg, 7, x7)
#define NATIVE_FE_9(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8)                            \
	NATIVE_FE_8(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7)                                \
	NATIVE_DEBRACKET sep W(F, arg, 8, x8)
#define NATIVE_FE_10(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9)                       \
	NATIVE_FE_9(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8)                            \
	NATIVE_DEBRACKET sep W(F, arg, 9, x9)
#define NATIVE_FE_11(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10)                  \
	NATIVE_FE_10(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9)                       \
	NATIVE_DEBRACKET sep W(F, arg, 10, x10)
#define NATIVE_FE_12(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11)             \
	NATIVE_FE_11(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10)                  \
	NATIVE_DEBRACKET sep W(F, arg, 11, x11)
#define NATIVE_FE_13(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12)        \
	NATIVE_FE_12(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11)             \
	NATIVE_DEBRACKET sep W(F, arg, 12, x12)
#define NATIVE_FE_14(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13)   \
	NATIVE_FE_13(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12)        \
	NATIVE_DEBRACKET sep W(F, arg, 13, x13)
#define NATIVE_FE_15(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14)                                                                          \
	NATIVE_FE_14(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13)   \
	NATIVE_DEBRACKET sep W(F, arg, 14, x14)
#define NATIVE_FE_16(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15)                                                                     \
	NATIVE_FE_15(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14)                                                                          \
	NATIVE_DEBRACKET sep W(F, arg, 15, x15)
#define NATIVE_FE_17(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16)                                                                \
	NATIVE_FE_16(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15)                                                                     \
	NATIVE_DEBRACKET sep W(F, arg, 16, x16)
#define NATIVE_FE_18(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17)                                                           \
	NATIVE_FE_17(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16)                                                                \
	NATIVE_DEBRACKET sep W(F, arg, 17, x17)
#define NATIVE_FE_19(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18)                                                      \
	NATIVE_FE_18(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17)                                                           \
	NATIVE_DEBRACKET sep W(F, arg, 18, x18)
#define NATIVE_FE_20(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19)                                                 \
	NATIVE_FE_19(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18)                                                      \
	NATIVE_DEBRACKET sep W(F, arg, 19, x19)
#define NATIVE_FE_21(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20)                                            \
	NATIVE_FE_20(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19)                                                 \
	NATIVE_DEBRACKET sep W(F, arg, 20, x20)
#define NATIVE_FE_22(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21)                                       \
	NATIVE_FE_21(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20)                                            \
	NATIVE_DEBRACKET sep W(F, arg, 21, x21)
#define NATIVE_FE_23(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22)                                  \
	NATIVE_FE_22(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21)                                       \
	NATIVE_DEBRACKET sep W(F, arg, 22, x22)
#define NATIVE_FE_24(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23)                             \
	NATIVE_FE_23(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22)                                  \
	NATIVE_DEBRACKET sep W(F, arg, 23, x23)
#define NATIVE_FE_25(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24)                        \
	NATIVE_FE_24(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23)                             \
	NATIVE_DEBRACKET sep W(F, arg, 24, x24)
#define NATIVE_FE_26(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25)                   \
	NATIVE_FE_25(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24)                        \
	NATIVE_DEBRACKET sep W(F, arg, 25, x25)
#define NATIVE_FE_27(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26)              \
	NATIVE_FE_26(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25)                   \
	NATIVE_DEBRACKET sep W(F, arg, 26, x26)
#define NATIVE_FE_28(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27)         \
	NATIVE_FE_27(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26)              \
	NATIVE_DEBRACKET sep W(F, arg, 27, x27)
#define NATIVE_FE_29(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28)    \
	NATIVE_FE_28(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27)         \
	NATIVE_DEBRACKET sep W(F, arg, 28, x28)
#define NATIVE_FE_30(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29)                                                                          \
	NATIVE_FE_29(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28)    \
	NATIVE_DEBRACKET sep W(F, arg, 29, x29)
#define NATIVE_FE_31(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30)                                                                     \
	NATIVE_FE_30(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29)                                                                          \
	NATIVE_DEBRACKET sep W(F, arg, 30, x30)
#define NATIVE_FE_32(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31)                                                                \
	NATIVE_FE_31(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30)                                                                     \
	NATIVE_DEBRACKET sep W(F, arg, 31, x31)
#define NATIVE_FE_33(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32)                                                           \
	NATIVE_FE_32(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31)                                                                \
	NATIVE_DEBRACKET sep W(F, arg, 32, x32)
#define NATIVE_FE_34(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33)                                                      \
	NATIVE_FE_33(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32)                                                           \
	NATIVE_DEBRACKET sep W(F, arg, 33, x33)
#define NATIVE_FE_35(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34)                                                 \
	NATIVE_FE_34(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33)                                                      \
	NATIVE_DEBRACKET sep W(F, arg, 34, x34)
#define NATIVE_FE_36(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35)                                            \
	NATIVE_FE_35(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34)                                                 \
	NATIVE_DEBRACKET sep W(F, arg, 35, x35)
#define NATIVE_FE_37(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36)                                       \
	NATIVE_FE_36(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35)                                            \
	NATIVE_DEBRACKET sep W(F, arg, 36, x36)
#define NATIVE_FE_38(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37)                                  \
	NATIVE_FE_37(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36)                                       \
	NATIVE_DEBRACKET sep W(F, arg, 37, x37)
#define NATIVE_FE_39(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38)                             \
	NATIVE_FE_38(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37)                                  \
	NATIVE_DEBRACKET sep W(F, arg, 38, x38)
#define NATIVE_FE_40(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39)                        \
	NATIVE_FE_39(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38)                             \
	NATIVE_DEBRACKET sep W(F, arg, 39, x39)
#define NATIVE_FE_41(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40)                   \
	NATIVE_FE_40(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39)                        \
	NATIVE_DEBRACKET sep W(F, arg, 40, x40)
#define NATIVE_FE_42(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41)              \
	NATIVE_FE_41(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40)                   \
	NATIVE_DEBRACKET sep W(F, arg, 41, x41)
#define NATIVE_FE_43(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42)         \
	NATIVE_FE_42(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41)              \
	NATIVE_DEBRACKET sep W(F, arg, 42, x42)
#define NATIVE_FE_44(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43)    \
	NATIVE_FE_43(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42)         \
	NATIVE_DEBRACKET sep W(F, arg, 43, x43)
#define NATIVE_FE_45(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44)                                                                          \
	NATIVE_FE_44(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43)    \
	NATIVE_DEBRACKET sep W(F, arg, 44, x44)
#define NATIVE_FE_46(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45)                                                                     \
	NATIVE_FE_45(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44)                                                                          \
	NATIVE_DEBRACKET sep W(F, arg, 45, x45)
#define NATIVE_FE_47(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46)                                                                \
	NATIVE_FE_46(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45)                                                                     \
	NATIVE_DEBRACKET sep W(F, arg, 46, x46)
#define NATIVE_FE_48(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47)                                                           \
	NATIVE_FE_47(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46)                                                                \
	NATIVE_DEBRACKET sep W(F, arg, 47, x47)
#define NATIVE_FE_49(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48)                                                      \
	NATIVE_FE_48(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47)                                                           \
	NATIVE_DEBRACKET sep W(F, arg, 48, x48)
#define NATIVE_FE_50(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49)                                                 \
	NATIVE_FE_49(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48)                                                      \
	NATIVE_DEBRACKET sep W(F, arg, 49, x49)
#define NATIVE_FE_51(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50)                                            \
	NATIVE_FE_50(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49)                                                 \
	NATIVE_DEBRACKET sep W(F, arg, 50, x50)
#define NATIVE_FE_52(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51)                                       \
	NATIVE_FE_51(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50)                                            \
	NATIVE_DEBRACKET sep W(F, arg, 51, x51)
#define NATIVE_FE_53(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52)                                  \
	NATIVE_FE_52(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51)                                       \
	NATIVE_DEBRACKET sep W(F, arg, 52, x52)
#define NATIVE_FE_54(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53)                             \
	NATIVE_FE_53(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52)                                  \
	NATIVE_DEBRACKET sep W(F, arg, 53, x53)
#define NATIVE_FE_55(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54)                        \
	NATIVE_FE_54(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53)                             \
	NATIVE_DEBRACKET sep W(F, arg, 54, x54)
#define NATIVE_FE_56(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55)                   \
	NATIVE_FE_55(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54)                        \
	NATIVE_DEBRACKET sep W(F, arg, 55, x55)
#define NATIVE_FE_57(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56)              \
	NATIVE_FE_56(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55)                   \
	NATIVE_DEBRACKET sep W(F, arg, 56, x56)
#define NATIVE_FE_58(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57)         \
	NATIVE_FE_57(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56)              \
	NATIVE_DEBRACKET sep W(F, arg, 57, x57)
#define NATIVE_FE_59(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58)    \
	NATIVE_FE_58(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57)         \
	NATIVE_DEBRACKET sep W(F, arg, 58, x58)
#define NATIVE_FE_60(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
                     x59)                                                                          \
	NATIVE_FE_59(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58)    \
	NATIVE_DEBRACKET sep W(F, arg, 59, x59)
#define NATIVE_FE_61(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
                     x59, x60)                                                                     \
	NATIVE_FE_60(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
	             x59)                                                                          \
	NATIVE_DEBRACKET sep W(F, arg, 60, x60)
#define NATIVE_FE_62(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
                     x59, x60, x61)                                                                \
	NATIVE_FE_61(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
	             x59, x60)                                                                     \
	NATIVE_DEBRACKET sep W(F, arg, 61, x61)
#define NATIVE_FE_63(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
                     x59, x60, x61, x62)                                                           \
	NATIVE_FE_62(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
	             x59, x60, x61)                                                                \
	NATIVE_DEBRACKET sep W(F, arg, 62, x62)
#define NATIVE_FE_64(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
                     x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
                     x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
                     x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
                     x59, x60, x61, x62, x63)                                                      \
	NATIVE_FE_63(W, F, sep, arg, x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13,   \
	             x14, x15, x16, x17, x18, x19, x20, x21, x22, x23, x24, x25, x26, x27, x28,    \
	             x29, x30, x31, x32, x33, x34, x35, x36, x37, x38, x39, x40, x41, x42, x43,    \
	             x44, x45, x46, x47, x48, x49, x50, x51, x52, x53, x54, x55, x56, x57, x58,    \
	             x59, x60, x61, x62)                                                           \
	NATIVE_DEBRACKET sep W(F, arg, 63, x63)

#include <zephyr/sys/util_listify.h>

#define NUM_VA_ARGS(...)      NATIVE_ARGS_(__VA_ARGS__)
#define MACRO_MAP_CAT(F, ...) FOR_EACH(F, (), __VA_ARGS__)

#endif
