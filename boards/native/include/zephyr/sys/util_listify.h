/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LISTIFY(), by Zephyr's name. Included by util_macro.h.
 */
#ifndef ZEPHYR_SYS_UTIL_LISTIFY_H_
#define ZEPHYR_SYS_UTIL_LISTIFY_H_

/* LISTIFY(n, F, (sep), …): F(0, …) sep F(1, …) … F(n - 1, …); n: a literal 0…64. */
#define LISTIFY(n, F, sep, ...)     NATIVE_LIST(n, F, sep, __VA_ARGS__)
#define NATIVE_LIST(n, F, sep, ...) NATIVE_LIST_##n(F, sep, __VA_ARGS__)
#define NATIVE_LIST_0(F, sep, ...)
#define NATIVE_LIST_1(F, sep, ...) F(0, __VA_ARGS__)
#define NATIVE_LIST_2(F, sep, ...)                                                                 \
	NATIVE_LIST_1(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(1, __VA_ARGS__)
#define NATIVE_LIST_3(F, sep, ...)                                                                 \
	NATIVE_LIST_2(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(2, __VA_ARGS__)
#define NATIVE_LIST_4(F, sep, ...)                                                                 \
	NATIVE_LIST_3(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(3, __VA_ARGS__)
#define NATIVE_LIST_5(F, sep, ...)                                                                 \
	NATIVE_LIST_4(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(4, __VA_ARGS__)
#define NATIVE_LIST_6(F, sep, ...)                                                                 \
	NATIVE_LIST_5(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(5, __VA_ARGS__)
#define NATIVE_LIST_7(F, sep, ...)                                                                 \
	NATIVE_LIST_6(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(6, __VA_ARGS__)
#define NATIVE_LIST_8(F, sep, ...)                                                                 \
	NATIVE_LIST_7(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(7, __VA_ARGS__)
#define NATIVE_LIST_9(F, sep, ...)                                                                 \
	NATIVE_LIST_8(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(8, __VA_ARGS__)
#define NATIVE_LIST_10(F, sep, ...)                                                                \
	NATIVE_LIST_9(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(9, __VA_ARGS__)
#define NATIVE_LIST_11(F, sep, ...)                                                                \
	NATIVE_LIST_10(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(10, __VA_ARGS__)
#define NATIVE_LIST_12(F, sep, ...)                                                                \
	NATIVE_LIST_11(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(11, __VA_ARGS__)
#define NATIVE_LIST_13(F, sep, ...)                                                                \
	NATIVE_LIST_12(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(12, __VA_ARGS__)
#define NATIVE_LIST_14(F, sep, ...)                                                                \
	NATIVE_LIST_13(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(13, __VA_ARGS__)
#define NATIVE_LIST_15(F, sep, ...)                                                                \
	NATIVE_LIST_14(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(14, __VA_ARGS__)
#define NATIVE_LIST_16(F, sep, ...)                                                                \
	NATIVE_LIST_15(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(15, __VA_ARGS__)
#define NATIVE_LIST_17(F, sep, ...)                                                                \
	NATIVE_LIST_16(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(16, __VA_ARGS__)
#define NATIVE_LIST_18(F, sep, ...)                                                                \
	NATIVE_LIST_17(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(17, __VA_ARGS__)
#define NATIVE_LIST_19(F, sep, ...)                                                                \
	NATIVE_LIST_18(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(18, __VA_ARGS__)
#define NATIVE_LIST_20(F, sep, ...)                                                                \
	NATIVE_LIST_19(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(19, __VA_ARGS__)
#define NATIVE_LIST_21(F, sep, ...)                                                                \
	NATIVE_LIST_20(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(20, __VA_ARGS__)
#define NATIVE_LIST_22(F, sep, ...)                                                                \
	NATIVE_LIST_21(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(21, __VA_ARGS__)
#define NATIVE_LIST_23(F, sep, ...)                                                                \
	NATIVE_LIST_22(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(22, __VA_ARGS__)
#define NATIVE_LIST_24(F, sep, ...)                                                                \
	NATIVE_LIST_23(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(23, __VA_ARGS__)
#define NATIVE_LIST_25(F, sep, ...)                                                                \
	NATIVE_LIST_24(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(24, __VA_ARGS__)
#define NATIVE_LIST_26(F, sep, ...)                                                                \
	NATIVE_LIST_25(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(25, __VA_ARGS__)
#define NATIVE_LIST_27(F, sep, ...)                                                                \
	NATIVE_LIST_26(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(26, __VA_ARGS__)
#define NATIVE_LIST_28(F, sep, ...)                                                                \
	NATIVE_LIST_27(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(27, __VA_ARGS__)
#define NATIVE_LIST_29(F, sep, ...)                                                                \
	NATIVE_LIST_28(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(28, __VA_ARGS__)
#define NATIVE_LIST_30(F, sep, ...)                                                                \
	NATIVE_LIST_29(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(29, __VA_ARGS__)
#define NATIVE_LIST_31(F, sep, ...)                                                                \
	NATIVE_LIST_30(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(30, __VA_ARGS__)
#define NATIVE_LIST_32(F, sep, ...)                                                                \
	NATIVE_LIST_31(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(31, __VA_ARGS__)
#define NATIVE_LIST_33(F, sep, ...)                                                                \
	NATIVE_LIST_32(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(32, __VA_ARGS__)
#define NATIVE_LIST_34(F, sep, ...)                                                                \
	NATIVE_LIST_33(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(33, __VA_ARGS__)
#define NATIVE_LIST_35(F, sep, ...)                                                                \
	NATIVE_LIST_34(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(34, __VA_ARGS__)
#define NATIVE_LIST_36(F, sep, ...)                                                                \
	NATIVE_LIST_35(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(35, __VA_ARGS__)
#define NATIVE_LIST_37(F, sep, ...)                                                                \
	NATIVE_LIST_36(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(36, __VA_ARGS__)
#define NATIVE_LIST_38(F, sep, ...)                                                                \
	NATIVE_LIST_37(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(37, __VA_ARGS__)
#define NATIVE_LIST_39(F, sep, ...)                                                                \
	NATIVE_LIST_38(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(38, __VA_ARGS__)
#define NATIVE_LIST_40(F, sep, ...)                                                                \
	NATIVE_LIST_39(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(39, __VA_ARGS__)
#define NATIVE_LIST_41(F, sep, ...)                                                                \
	NATIVE_LIST_40(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(40, __VA_ARGS__)
#define NATIVE_LIST_42(F, sep, ...)                                                                \
	NATIVE_LIST_41(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(41, __VA_ARGS__)
#define NATIVE_LIST_43(F, sep, ...)                                                                \
	NATIVE_LIST_42(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(42, __VA_ARGS__)
#define NATIVE_LIST_44(F, sep, ...)                                                                \
	NATIVE_LIST_43(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(43, __VA_ARGS__)
#define NATIVE_LIST_45(F, sep, ...)                                                                \
	NATIVE_LIST_44(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(44, __VA_ARGS__)
#define NATIVE_LIST_46(F, sep, ...)                                                                \
	NATIVE_LIST_45(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(45, __VA_ARGS__)
#define NATIVE_LIST_47(F, sep, ...)                                                                \
	NATIVE_LIST_46(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(46, __VA_ARGS__)
#define NATIVE_LIST_48(F, sep, ...)                                                                \
	NATIVE_LIST_47(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(47, __VA_ARGS__)
#define NATIVE_LIST_49(F, sep, ...)                                                                \
	NATIVE_LIST_48(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(48, __VA_ARGS__)
#define NATIVE_LIST_50(F, sep, ...)                                                                \
	NATIVE_LIST_49(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(49, __VA_ARGS__)
#define NATIVE_LIST_51(F, sep, ...)                                                                \
	NATIVE_LIST_50(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(50, __VA_ARGS__)
#define NATIVE_LIST_52(F, sep, ...)                                                                \
	NATIVE_LIST_51(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(51, __VA_ARGS__)
#define NATIVE_LIST_53(F, sep, ...)                                                                \
	NATIVE_LIST_52(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(52, __VA_ARGS__)
#define NATIVE_LIST_54(F, sep, ...)                                                                \
	NATIVE_LIST_53(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(53, __VA_ARGS__)
#define NATIVE_LIST_55(F, sep, ...)                                                                \
	NATIVE_LIST_54(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(54, __VA_ARGS__)
#define NATIVE_LIST_56(F, sep, ...)                                                                \
	NATIVE_LIST_55(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(55, __VA_ARGS__)
#define NATIVE_LIST_57(F, sep, ...)                                                                \
	NATIVE_LIST_56(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(56, __VA_ARGS__)
#define NATIVE_LIST_58(F, sep, ...)                                                                \
	NATIVE_LIST_57(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(57, __VA_ARGS__)
#define NATIVE_LIST_59(F, sep, ...)                                                                \
	NATIVE_LIST_58(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(58, __VA_ARGS__)
#define NATIVE_LIST_60(F, sep, ...)                                                                \
	NATIVE_LIST_59(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(59, __VA_ARGS__)
#define NATIVE_LIST_61(F, sep, ...)                                                                \
	NATIVE_LIST_60(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(60, __VA_ARGS__)
#define NATIVE_LIST_62(F, sep, ...)                                                                \
	NATIVE_LIST_61(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(61, __VA_ARGS__)
#define NATIVE_LIST_63(F, sep, ...)                                                                \
	NATIVE_LIST_62(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(62, __VA_ARGS__)
#define NATIVE_LIST_64(F, sep, ...)                                                                \
	NATIVE_LIST_63(F, sep, __VA_ARGS__) NATIVE_DEBRACKET sep F(63, __VA_ARGS__)

#endif
