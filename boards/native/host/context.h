/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the context switch's C part and its machine-dependent part know of each other. The functions
 * the kernel calls are in kernel/port.h.
 */
#ifndef NATIVE_HOST_CONTEXT_H_
#define NATIVE_HOST_CONTEXT_H_

#if defined(__x86_64__) || defined(__aarch64__)
#define CONTEXT_IN_ASSEMBLER 1

/* Pushes the callee-saved state, stores the stack pointer in *from_sp, goes on from to_sp. */
void context_swap(void **from_sp, void *to_sp);
/* Where a new context begins: calls context_begin(arg), both found in its first frame. */
void context_trampoline(void);
#else
#define CONTEXT_IN_ASSEMBLER 0
#endif

#if defined(__SANITIZE_ADDRESS__)
#define CONTEXT_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CONTEXT_SANITIZED 1
#endif
#endif
#ifndef CONTEXT_SANITIZED
#define CONTEXT_SANITIZED 0
#endif

#endif
