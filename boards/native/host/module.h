/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A module of the host side: its command-line options, its control operations, and when it starts
 * and ends. HOST_MODULE(name) = {…}; anywhere in the program registers one; main() walks them by
 * `order`.
 *
 *   HOST_MODULE(lamp_module) = {
 *           .name = "lamp", .order = 50, .options = lamp_options, .ops = lamp_ops,
 *           .start = lamp_start, .off = lamp_off,
 *   };
 */
#ifndef NATIVE_HOST_MODULE_H_
#define NATIVE_HOST_MODULE_H_

#include <stdbool.h>

#include "host/options.h"

struct control_op;
struct control_fault;

enum host_order {
	HOST_ORDER_BASE = 10,    /* clock, trace */
	HOST_ORDER_WIRES = 30,   /* UARTs, CAN */
	HOST_ORDER_BOARD = 50,   /* models, recorder, devices */
	HOST_ORDER_CONTROL = 90, /* the control socket opens when all else is there */
};

struct host_module {
	const char *name; /* heading in --help */
	int order;
	/* Opening its real outputs makes them safe, or these need it: --off has only such ones. */
	bool drives;
	const struct host_option *options;  /* NULL or ended by {0} */
	const struct control_op *ops;       /* NULL or ended by {0}; host/control.h */
	const struct control_fault *faults; /* NULL or ended by {0}; host/control.h */
	/* After the options, before the kernel. Carried data is there (host/carry.h). 0; else it
	 * has said why: the process's exit status (2: an option is wrong), or -1. */
	int (*start)(void);
	/* The kernel has started and is idle for the first time. */
	void (*up)(void);
	/* The instant of a reset or of the end: outputs fall to their reset state. No blocking. */
	void (*off)(void);
	/* Before a reset: carry_put(), carry_fd(). */
	void (*save)(void);
	/* The end of the process, in reverse order: close, unlink, free. */
	void (*stop)(void);
};

/* The section's name is no function's: the assembler would take a call for one into the section. */
#define HOST_MODULE(var)                                                                           \
	static const struct host_module var;                                                       \
	__attribute__((section("host_module_table"),                                               \
	               used)) static const struct host_module *const var##_entry = &var;           \
	static const struct host_module var

/* All modules in order; *count of them. */
const struct host_module *const *host_modules(size_t *count);

/* From now on there are only the modules that drive real outputs, and one that fails to start stops
 * no other. */
void host_only_outputs(void);

/* Calls the hook of every module: start and up in order (the first failure to start ends it, unless
 * there are only outputs), the others in reverse. host_start: 0, else the first exit status. */
int host_start(void);
void host_up(void);
void host_off(void);
void host_save(void);
void host_stop(void);

#endif
