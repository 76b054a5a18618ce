/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Assertions of the core: for bugs, never for values from a bus, flash or sensor.
 *
 * They stay on in release. The application provides pharos_assert_failed(): lamp off at that
 * instant, then reset. It may be called from any context and must not return.
 * It is the one symbol besides mem* and str* that the core's objects leave undefined.
 */
#ifndef PHAROS_CORE_ASSERT_H
#define PHAROS_CORE_ASSERT_H

_Noreturn void pharos_assert_failed(const char *file, int line);

#define PHAROS_ASSERT(condition)                                                                   \
	do {                                                                                       \
		if (!(condition)) {                                                                \
			pharos_assert_failed(__FILE__, __LINE__);                                  \
		}                                                                                  \
	} while (0)

#endif
