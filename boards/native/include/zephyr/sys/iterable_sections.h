/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Objects of one type, defined anywhere in the program and visited as an array, in link order.
 *
 * The section's name is a C identifier, so the linker itself provides the start and stop symbols
 * and no linker script is needed. Object files must be linked as objects, not taken from an archive
 * on demand.
 */
#ifndef ZEPHYR_SYS_ITERABLE_SECTIONS_H_
#define ZEPHYR_SYS_ITERABLE_SECTIONS_H_

#include <stddef.h>

#define NATIVE_SECTION_START(secname) __start_native_##secname
#define NATIVE_SECTION_STOP(secname)  __stop_native_##secname

/* gcc would reverse the objects of a file; clang keeps their order. */
#if defined(__clang__)
#define NATIVE_IN_ORDER
#else
#define NATIVE_IN_ORDER __attribute__((no_reorder))
#endif

#define TYPE_SECTION_ITERABLE(type, varname, secname, section_postfix)                             \
	NATIVE_IN_ORDER type varname                                                               \
		__attribute__((section("native_" #secname), used, aligned(__alignof__(type))))

#define STRUCT_SECTION_ITERABLE(struct_type, varname)                                              \
	TYPE_SECTION_ITERABLE(struct struct_type, varname, struct_type, varname)

#define STRUCT_SECTION_ITERABLE_ALTERNATE(secname, struct_type, varname)                           \
	TYPE_SECTION_ITERABLE(struct struct_type, varname, secname, varname)

#define STRUCT_SECTION_ITERABLE_NAMED(struct_type, name, varname)                                  \
	TYPE_SECTION_ITERABLE(struct struct_type, varname, struct_type, name)

/* const or not must be the same for all objects of a section: the iterator is never const here. */
#define TYPE_SECTION_FOREACH(type, secname, iterator)                                              \
	extern type NATIVE_SECTION_START(secname)[] __attribute__((weak));                         \
	extern type NATIVE_SECTION_STOP(secname)[] __attribute__((weak));                          \
	for (type *iterator = NATIVE_SECTION_START(secname);                                       \
	     iterator < (type *)NATIVE_SECTION_STOP(secname); iterator++)

#define STRUCT_SECTION_FOREACH_ALTERNATE(secname, struct_type, iterator)                           \
	TYPE_SECTION_FOREACH(struct struct_type, secname, iterator)

#define STRUCT_SECTION_FOREACH(struct_type, iterator)                                              \
	STRUCT_SECTION_FOREACH_ALTERNATE(struct_type, struct_type, iterator)

#define STRUCT_SECTION_COUNT_ALTERNATE(secname, struct_type, dst)                                  \
	do {                                                                                       \
		extern struct struct_type NATIVE_SECTION_START(secname)[] __attribute__((weak));   \
		extern struct struct_type NATIVE_SECTION_STOP(secname)[] __attribute__((weak));    \
		*(dst) = (size_t)(NATIVE_SECTION_STOP(secname) - NATIVE_SECTION_START(secname));   \
	} while (0)

#define STRUCT_SECTION_COUNT(struct_type, dst)                                                     \
	STRUCT_SECTION_COUNT_ALTERNATE(struct_type, struct_type, dst)

#define STRUCT_SECTION_GET(struct_type, index, dst)                                                \
	do {                                                                                       \
		extern struct struct_type NATIVE_SECTION_START(struct_type)[];                     \
		*(dst) = &NATIVE_SECTION_START(struct_type)[index];                                \
	} while (0)

#endif
