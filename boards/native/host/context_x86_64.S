/* SPDX-License-Identifier: Apache-2.0 */
/* System V ABI. The frame's layout is known to port_context_init() in context.c. */
#if defined(__x86_64__)
	.text
	.globl context_swap
	.hidden context_swap
	.type context_swap, @function
	.p2align 4
context_swap:
	.cfi_startproc
	pushq %rbp
	pushq %rbx
	pushq %r12
	pushq %r13
	pushq %r14
	pushq %r15
	subq $8, %rsp
	stmxcsr (%rsp)
	fnstcw 4(%rsp)
	movq %rsp, (%rdi)
	movq %rsi, %rsp
	ldmxcsr (%rsp)
	fldcw 4(%rsp)
	addq $8, %rsp
	popq %r15
	popq %r14
	popq %r13
	popq %r12
	popq %rbx
	popq %rbp
	ret
	.cfi_endproc
	.size context_swap, . - context_swap

	.globl context_trampoline
	.hidden context_trampoline
	.type context_trampoline, @function
	.p2align 4
context_trampoline:
	.cfi_startproc
	.cfi_undefined rip
	movq %r12, %rdi
	call *%r13
	ud2
	.cfi_endproc
	.size context_trampoline, . - context_trampoline
#endif

	.section .note.GNU-stack, "", %progbits
