/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Devicetree from C, by Zephyr's names. Values come from devicetree_generated.h, which
 * scripts/gen_devicetree.py makes from native.dts and the bindings.
 *
 * A node identifier is what DT_NODELABEL(), DT_ALIAS(), DT_CHOSEN(), DT_INST() or DT_DRV_INST()
 * expand to. Names are lower case with every other character as an underscore. Asking for a value
 * of a node, property or cell that isn't there is a build error (an undeclared name); the …_EXISTS,
 * …_HAS_… and …_OR forms don't ask.
 *
 * DT_NODE_PATH() and the like give string literals, DT_PROP() of arrays a braced initialiser,
 * booleans 0 or 1.
 */
#ifndef ZEPHYR_DEVICETREE_H_
#define ZEPHYR_DEVICETREE_H_

#include <devicetree_generated.h>

#define NATIVE_DT_CAT(a, b)                     NATIVE_DT_CAT_(a, b)
#define NATIVE_DT_CAT_(a, b)                    a##b
#define NATIVE_DT_CAT3(a, b, c)                 NATIVE_DT_CAT3_(a, b, c)
#define NATIVE_DT_CAT3_(a, b, c)                a##b##c
#define NATIVE_DT_CAT4(a, b, c, d)              NATIVE_DT_CAT4_(a, b, c, d)
#define NATIVE_DT_CAT4_(a, b, c, d)             a##b##c##d
#define NATIVE_DT_CAT5(a, b, c, d, e)           NATIVE_DT_CAT5_(a, b, c, d, e)
#define NATIVE_DT_CAT5_(a, b, c, d, e)          a##b##c##d##e
#define NATIVE_DT_CAT6(a, b, c, d, e, f)        NATIVE_DT_CAT6_(a, b, c, d, e, f)
#define NATIVE_DT_CAT6_(a, b, c, d, e, f)       a##b##c##d##e##f
#define NATIVE_DT_CAT8(a, b, c, d, e, f, g, h)  NATIVE_DT_CAT8_(a, b, c, d, e, f, g, h)
#define NATIVE_DT_CAT8_(a, b, c, d, e, f, g, h) a##b##c##d##e##f##g##h

/* 1 when the macro named by flag is defined as 1, else 0 */
#define NATIVE_DT_FLAG_1             ignored,
#define NATIVE_DT_IS_SET(flag)       NATIVE_DT_IS_SET_(flag)
#define NATIVE_DT_IS_SET_(value)     NATIVE_DT_SECOND(NATIVE_DT_FLAG_##value 1, 0, )
#define NATIVE_DT_SECOND(...)        NATIVE_DT_SECOND_(__VA_ARGS__)
#define NATIVE_DT_SECOND_(a, b, ...) b

/* then and other are in parentheses, which are taken off */
#define NATIVE_DT_IF(flag, then, other)  NATIVE_DT_IF_(NATIVE_DT_IS_SET(flag), then, other)
#define NATIVE_DT_IF_(bit, then, other)  NATIVE_DT_IF__(bit, then, other)
#define NATIVE_DT_IF__(bit, then, other) NATIVE_DT_IF_##bit(then, other)
#define NATIVE_DT_IF_1(then, other)      NATIVE_DT_BARE then
#define NATIVE_DT_IF_0(then, other)      NATIVE_DT_BARE other
#define NATIVE_DT_BARE(...)              __VA_ARGS__

/* --- node identifiers --- */
#define DT_INVALID_NODE            NATIVE_DT_NO_NODE
#define DT_ROOT                    DT_N0
#define DT_NODELABEL(label)        NATIVE_DT_CAT(DT_NODELABEL_, label)
#define DT_ALIAS(alias)            NATIVE_DT_CAT(DT_ALIAS_, alias)
#define DT_CHOSEN(prop)            NATIVE_DT_CAT(DT_CHOSEN_, prop)
#define DT_INST(inst, compat)      NATIVE_DT_CAT4(DT_COMPAT_, compat, _I, inst)
#define DT_DRV_INST(inst)          DT_INST(inst, DT_DRV_COMPAT)
#define DT_PARENT(node_id)         NATIVE_DT_CAT(node_id, _PARENT)
#define DT_SAME_NODE(n1, n2)       (DT_DEP_ORD(n1) == DT_DEP_ORD(n2))
#define DT_DEP_ORD(node_id)        NATIVE_DT_CAT(node_id, _ORD)
#define DT_NODE_PATH(node_id)      NATIVE_DT_CAT(node_id, _PATH)
#define DT_NODE_FULL_NAME(node_id) NATIVE_DT_CAT(node_id, _FULL_NAME)

/* --- is it there? 0 or 1, also in #if --- */
#define DT_NODE_EXISTS(node_id) NATIVE_DT_IS_SET(NATIVE_DT_CAT(node_id, _EXISTS))
#define DT_NODE_HAS_STATUS(node_id, status)                                                        \
	NATIVE_DT_IS_SET(NATIVE_DT_CAT3(node_id, _STATUS_, status))
#define DT_NODE_HAS_PROP(node_id, prop)                                                            \
	NATIVE_DT_IS_SET(NATIVE_DT_CAT4(node_id, _P_, prop, _EXISTS))
#define DT_NODE_HAS_COMPAT(node_id, compat)                                                        \
	NATIVE_DT_IS_SET(NATIVE_DT_CAT3(node_id, _COMPAT_MATCHES_, compat))
#define DT_HAS_ALIAS(alias) DT_NODE_EXISTS(DT_ALIAS(alias))
#define DT_HAS_CHOSEN(prop) DT_NODE_EXISTS(DT_CHOSEN(prop))
#define DT_HAS_COMPAT_STATUS_OKAY(compat)                                                          \
	NATIVE_DT_IS_SET(NATIVE_DT_CAT3(DT_COMPAT_, compat, _HAS_OKAY))
#define DT_NUM_INST_STATUS_OKAY(compat)                                                            \
	NATIVE_DT_IF(NATIVE_DT_CAT3(DT_COMPAT_, compat, _HAS_OKAY),                                \
	             (NATIVE_DT_CAT3(DT_COMPAT_, compat, _NUM_OKAY)), (0))
#define DT_PROP_HAS_IDX(node_id, prop, idx)                                                        \
	NATIVE_DT_IS_SET(NATIVE_DT_CAT6(node_id, _P_, prop, _IDX_, idx, _EXISTS))
#define DT_PHA_HAS_CELL_AT_IDX(node_id, pha, idx, cell)                                            \
	NATIVE_DT_IS_SET(NATIVE_DT_PHA_CELL(node_id, pha, idx, cell, _EXISTS))

/* --- values --- */
#define DT_PROP(node_id, prop)             NATIVE_DT_CAT3(node_id, _P_, prop)
#define DT_PROP_LEN(node_id, prop)         NATIVE_DT_CAT4(node_id, _P_, prop, _LEN)
#define DT_PROP_BY_IDX(node_id, prop, idx) NATIVE_DT_CAT5(node_id, _P_, prop, _IDX_, idx)
#define DT_PROP_OR(node_id, prop, default_value)                                                   \
	NATIVE_DT_IF(NATIVE_DT_CAT4(node_id, _P_, prop, _EXISTS), (DT_PROP(node_id, prop)),        \
	             (default_value))
#define DT_ENUM_IDX(node_id, prop)       NATIVE_DT_CAT4(node_id, _P_, prop, _ENUM_IDX)
#define DT_STRING_TOKEN(node_id, prop)   NATIVE_DT_CAT4(node_id, _P_, prop, _STRING_TOKEN)
#define DT_REG_ADDR(node_id)             DT_REG_ADDR_BY_IDX(node_id, 0)
#define DT_REG_ADDR_BY_IDX(node_id, idx) NATIVE_DT_CAT4(node_id, _REG_IDX_, idx, _ADDRESS)
#define DT_REG_SIZE(node_id)             DT_REG_SIZE_BY_IDX(node_id, 0)
#define DT_REG_SIZE_BY_IDX(node_id, idx) NATIVE_DT_CAT4(node_id, _REG_IDX_, idx, _SIZE)

#define DT_PHANDLE(node_id, prop)              DT_PHANDLE_BY_IDX(node_id, prop, 0)
#define DT_PHANDLE_BY_IDX(node_id, prop, idx)  NATIVE_DT_CAT6(node_id, _P_, prop, _IDX_, idx, _PH)
#define DT_PHA(node_id, pha, cell)             DT_PHA_BY_IDX(node_id, pha, 0, cell)
#define DT_PHA_BY_IDX(node_id, pha, idx, cell) NATIVE_DT_PHA_CELL(node_id, pha, idx, cell, )
#define DT_PHA_BY_IDX_OR(node_id, pha, idx, cell, default_value)                                   \
	NATIVE_DT_IF(NATIVE_DT_PHA_CELL(node_id, pha, idx, cell, _EXISTS),                         \
	             (DT_PHA_BY_IDX(node_id, pha, idx, cell)), (default_value))
/* pasted in one go: a part of the name may be a macro with a value */
#define NATIVE_DT_PHA_CELL(node_id, pha, idx, cell, suffix)                                        \
	NATIVE_DT_CAT8(node_id, _P_, pha, _IDX_, idx, _VAL_, cell, suffix)

/* --- for each --- */
#define DT_FOREACH_CHILD(node_id, fn) NATIVE_DT_CAT(node_id, _FOREACH_CHILD)(fn)
#define DT_FOREACH_CHILD_VARGS(node_id, fn, ...)                                                   \
	NATIVE_DT_CAT(node_id, _FOREACH_CHILD_VARGS)(fn, __VA_ARGS__)
#define DT_FOREACH_CHILD_STATUS_OKAY(node_id, fn)                                                  \
	NATIVE_DT_CAT(node_id, _FOREACH_CHILD_STATUS_OKAY)(fn)
#define DT_FOREACH_STATUS_OKAY(compat, fn)                                                         \
	NATIVE_DT_IF(NATIVE_DT_CAT3(DT_COMPAT_, compat, _HAS_OKAY),                                \
	             (NATIVE_DT_CAT3(DT_COMPAT_, compat, _FOREACH_OKAY)(fn)), ())

/* --- the instances of DT_DRV_COMPAT --- */
#define DT_INST_PROP(inst, prop) DT_PROP(DT_DRV_INST(inst), prop)
#define DT_INST_PROP_OR(inst, prop, default_value)                                                 \
	DT_PROP_OR(DT_DRV_INST(inst), prop, default_value)
#define DT_INST_PROP_LEN(inst, prop)         DT_PROP_LEN(DT_DRV_INST(inst), prop)
#define DT_INST_PROP_BY_IDX(inst, prop, idx) DT_PROP_BY_IDX(DT_DRV_INST(inst), prop, idx)
#define DT_INST_NODE_HAS_PROP(inst, prop)    DT_NODE_HAS_PROP(DT_DRV_INST(inst), prop)
#define DT_INST_REG_ADDR(inst)               DT_REG_ADDR(DT_DRV_INST(inst))
#define DT_INST_ENUM_IDX(inst, prop)         DT_ENUM_IDX(DT_DRV_INST(inst), prop)
#define DT_INST_PHANDLE(inst, prop)          DT_PHANDLE(DT_DRV_INST(inst), prop)
#define DT_INST_PARENT(inst)                 DT_PARENT(DT_DRV_INST(inst))
#define DT_INST_FOREACH_STATUS_OKAY(fn)                                                            \
	NATIVE_DT_IF(NATIVE_DT_CAT3(DT_COMPAT_, DT_DRV_COMPAT, _HAS_OKAY),                         \
	             (NATIVE_DT_CAT3(DT_COMPAT_, DT_DRV_COMPAT, _FOREACH_OKAY_INST)(fn)), ())

#include <zephyr/devicetree/gpio.h>
#include <zephyr/devicetree/io-channels.h>
#include <zephyr/devicetree/pwms.h>

#endif
