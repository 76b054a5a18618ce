/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What Zephyr names differently from 3.4 to 4.x, by its newest name. The one place for renames: a
 * file that needs one includes this after Zephyr's own headers.
 */
#ifndef PHAROS_COMPAT_H_
#define PHAROS_COMPAT_H_

#include <zephyr/device.h>
#include <zephyr/drivers/can.h>
#include <zephyr/kernel.h>

/* 4.1: the table of a driver's functions, put where the build can check its class. */
#ifndef DEVICE_API
#define DEVICE_API(class_, name_) const struct class_##_driver_api name_
#endif

/* 3.5: takes the block; before, the address of a pointer to it. ZV: see zephyr/app.cmake. */
#if defined(ZV) && ZV < 30499
#define k_mem_slab_free(slab_, block_)                                                             \
	do {                                                                                       \
		void *compat_block = (block_);                                                     \
		(k_mem_slab_free)((slab_), &compat_block);                                         \
	} while (false)
#endif

/* 3.6: a filter no longer tells data frames from remote ones, and FD frames from classic ones. */
#ifndef CAN_FILTER_DATA
#define CAN_FILTER_DATA 0
#endif
#ifndef CAN_FILTER_FDF
#define CAN_FILTER_FDF 0
#endif
/*
 * Where it tells them apart, M_CAN's driver (STM32's FDCAN) looks at the first filter only that an
 * id matches, so that two filters with the same ids, for both kinds, are no use: one of them.
 */
#ifndef PHAROS_CAN_FILTERS_EXCLUDE
#define PHAROS_CAN_FILTERS_EXCLUDE (CAN_FILTER_FDF != 0 && IS_ENABLED(CONFIG_CAN_MCAN))
#endif

/* 3.7: what a fault left on the stack. The old name is that of Arm, Arm64, POSIX, RISC-V, SPARC. */
#if defined(ZV) && ZV < 30699
#define arch_esf __esf
#endif

/* 4.4: the shell's bypass has a pointer for its callback, which nothing here needs. */
#if defined(ZV) && ZV >= 40399
#define shell_set_bypass(shell_, callback_) (shell_set_bypass)((shell_), (callback_), NULL)
#define SHELL_BYPASS_PARAMS(...)            __VA_ARGS__, void *user_data
#else
#define SHELL_BYPASS_PARAMS(...) __VA_ARGS__
#endif

#endif
