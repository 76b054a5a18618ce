/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thread stacks. Host library calls run on them too, so each is larger than asked by
 * NATIVE_STACK_HEADROOM; untouched pages cost nothing. Every stack given to k_thread_create() must
 * be declared by these macros.
 */
#ifndef ZEPHYR_KERNEL_THREAD_STACK_H_
#define ZEPHYR_KERNEL_THREAD_STACK_H_

#include <stddef.h>

#include <zephyr/sys/util.h>

#if defined(__SANITIZE_ADDRESS__)
#define NATIVE_STACK_HEADROOM (128 * 1024)
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NATIVE_STACK_HEADROOM (128 * 1024)
#endif
#endif
#ifndef NATIVE_STACK_HEADROOM
#define NATIVE_STACK_HEADROOM (32 * 1024)
#endif

struct z_thread_stack_element {
	char data;
};

typedef struct z_thread_stack_element k_thread_stack_t;

#define NATIVE_STACK_ALIGN         16
#define K_THREAD_STACK_LEN(size)   (ROUND_UP(size, NATIVE_STACK_ALIGN) + NATIVE_STACK_HEADROOM)
#define K_THREAD_STACK_SIZEOF(sym) (sizeof(sym) - NATIVE_STACK_HEADROOM)
#define K_THREAD_STACK_BUFFER(sym) ((char *)(sym))
#define K_THREAD_STACK_RESERVED    0

#define K_THREAD_STACK_DECLARE(sym, size) extern k_thread_stack_t sym[K_THREAD_STACK_LEN(size)]
#define K_THREAD_STACK_DEFINE(sym, size)                                                           \
	k_thread_stack_t __aligned(NATIVE_STACK_ALIGN) sym[K_THREAD_STACK_LEN(size)]
#define K_THREAD_STACK_ARRAY_DEFINE(sym, count, size)                                              \
	k_thread_stack_t __aligned(NATIVE_STACK_ALIGN) sym[count][K_THREAD_STACK_LEN(size)]
#define K_THREAD_STACK_ARRAY_DECLARE(sym, count, size)                                             \
	extern k_thread_stack_t sym[count][K_THREAD_STACK_LEN(size)]
#define K_THREAD_STACK_MEMBER(sym, size)                                                           \
	k_thread_stack_t __aligned(NATIVE_STACK_ALIGN) sym[K_THREAD_STACK_LEN(size)]

#define K_KERNEL_STACK_LEN(size)                      K_THREAD_STACK_LEN(size)
#define K_KERNEL_STACK_SIZEOF(sym)                    K_THREAD_STACK_SIZEOF(sym)
#define K_KERNEL_STACK_DECLARE(sym, size)             K_THREAD_STACK_DECLARE(sym, size)
#define K_KERNEL_STACK_DEFINE(sym, size)              K_THREAD_STACK_DEFINE(sym, size)
#define K_KERNEL_STACK_MEMBER(sym, size)              K_THREAD_STACK_MEMBER(sym, size)
#define K_KERNEL_STACK_ARRAY_DEFINE(sym, count, size) K_THREAD_STACK_ARRAY_DEFINE(sym, count, size)

#endif
