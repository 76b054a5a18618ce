/* SPDX-License-Identifier: Apache-2.0 */
#ifndef ZEPHYR_TYPES_H_
#define ZEPHYR_TYPES_H_

#include <stddef.h>
#include <stdint.h>

typedef uintptr_t mem_addr_t;

#endif
