/* SPDX-License-Identifier: Apache-2.0 */
#include "context.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "../kernel/port.h"

#if CONTEXT_SANITIZED
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>

/* Frames that are gone are watched whichever compiler's default that is: each switch hands over. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
	return "detect_stack_use_after_return=1";
}

/*
 * The flow of control that came first runs on the host's own stack, whose bounds nobody gave: they
 * are learned when it is left for the first time.
 */
static struct port_context *left;

static void sanitizer_leave(struct port_context *from, const struct port_context *to)
{
	left = from;
	__sanitizer_start_switch_fiber(from != NULL ? &from->fiber : NULL, to->stack,
	                               to->stack_size);
}

static void sanitizer_arrive(struct port_context *ctx)
{
	const void *bottom;
	size_t size;

	__sanitizer_finish_switch_fiber(ctx->fiber, &bottom, &size);
	if (left != NULL && left->stack == NULL) {
		left->stack = (void *)(uintptr_t)bottom;
		left->stack_size = size;
	}
}

void port_stack_claim(void *stack, size_t size)
{
	__asan_unpoison_memory_region(stack, size);
}
#else
static void sanitizer_leave(struct port_context *from, const struct port_context *to)
{
	(void)from;
	(void)to;
}

static void sanitizer_arrive(struct port_context *ctx)
{
	(void)ctx;
}

void port_stack_claim(void *stack, size_t size)
{
	(void)stack;
	(void)size;
}
#endif

/* The first code of every context. */
static void context_begin(struct port_context *ctx)
{
	sanitizer_arrive(ctx);
	ctx->entry(ctx->arg);
	abort();
}

#if CONTEXT_IN_ASSEMBLER
#if defined(__x86_64__)
/* mxcsr and x87 control word, r15 r14 r13 r12 rbx rbp, return address */
#define FRAME_WORDS  8
#define FRAME_FN     3 /* r13 */
#define FRAME_ARG    4 /* r12 */
#define FRAME_RETURN 7
/* All exceptions masked, round to nearest: the ABI's state at a program's start. */
#define FRAME_FLOAT  0x0000037f00001f80ULL
#else
/* d8…d15, x19…x30 */
#define FRAME_WORDS  20
#define FRAME_ARG    8  /* x19 */
#define FRAME_FN     9  /* x20 */
#define FRAME_RETURN 19 /* x30 */
#endif

void port_context_init(struct port_context *ctx, void *stack, size_t size, void (*entry)(void *),
                       void *arg)
{
	uintptr_t *frame = (uintptr_t *)(((uintptr_t)stack + size) & ~(uintptr_t)15);

	/* Two words stay free above, so that the trampoline's call finds the ABI's alignment. */
	frame -= FRAME_WORDS + 2;
	memset(frame, 0, (FRAME_WORDS + 2) * sizeof(*frame));
#if defined(__x86_64__)
	frame[0] = FRAME_FLOAT;
#endif
	frame[FRAME_FN] = (uintptr_t)context_begin;
	frame[FRAME_ARG] = (uintptr_t)ctx;
	frame[FRAME_RETURN] = (uintptr_t)context_trampoline;
	*ctx = (struct port_context){
		.sp = frame, .stack = stack, .stack_size = size, .entry = entry, .arg = arg};
}

/* Touches no local: a thread that ends has just given its fake stack, with its frames, back. */
static void swap(struct port_context *from, struct port_context *to)
{
	static void *unused;

	context_swap(from != NULL ? &from->sp : &unused, to->sp);
}
#else
#include <ucontext.h>

/* makecontext() passes ints only. */
static void ucontext_main(unsigned int high, unsigned int low)
{
	context_begin((struct port_context *)(((uintptr_t)high << 16 << 16) | low));
}

/* The ucontext lies at the top of its stack. */
void port_context_init(struct port_context *ctx, void *stack, size_t size, void (*entry)(void *),
                       void *arg)
{
	const uintptr_t top = ((uintptr_t)stack + size - sizeof(ucontext_t)) & ~(uintptr_t)63;
	ucontext_t *const uc = (ucontext_t *)top;
	const uintptr_t self = (uintptr_t)ctx;

	(void)getcontext(uc);
	uc->uc_stack.ss_sp = stack;
	uc->uc_stack.ss_size = top - (uintptr_t)stack;
	uc->uc_link = NULL;
	makecontext(uc, (void (*)(void))ucontext_main, 2, (unsigned int)(self >> 16 >> 16),
	            (unsigned int)self);
	*ctx = (struct port_context){
		.sp = uc, .stack = stack, .stack_size = size, .entry = entry, .arg = arg};
}

static void swap(struct port_context *from, struct port_context *to)
{
	static ucontext_t first;

	if (from == NULL) {
		(void)setcontext(to->sp);
		abort();
	}
	if (from->sp == NULL) {
		from->sp = &first;
	}
	(void)swapcontext(from->sp, to->sp);
}
#endif

void port_context_switch(struct port_context *from, struct port_context *to)
{
	sanitizer_leave(from, to);
	swap(from, to);
	sanitizer_arrive(from);
}
