/* SPDX-License-Identifier: Apache-2.0 */
/* A suspended flow of control: plain data inside the object it belongs to. Its functions are in
 * port.h. */
#ifndef NATIVE_CONTEXT_H_
#define NATIVE_CONTEXT_H_

#include <stddef.h>

struct port_context {
	void *sp;          /* saved stack pointer, or the ucontext on other machines */
	void *stack;       /* lowest address */
	size_t stack_size; /* bytes */
	void (*entry)(void *arg);
	void *arg;
	void *fiber; /* address sanitizer's fake stack while suspended */
};

#endif
