/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Wiring and the thread table.
 *
 * The strobe is not in the table: it is a timer (threads/strobe.c); nor is storage: it is a work
 * queue. The shell's thread is Zephyr's.
 */
#include <zephyr/init.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>

#include "threads/can_link.h"
#include "threads/command.h"
#include "threads/devices.h"
#include "threads/inputs.h"
#include "threads/reset_cause.h"
#include "threads/startup.h"
#include "threads/storage.h"
#include "threads/supervisor.h"
#include "threads/thermal.h"
#include "threads/trial.h"
#include "threads/uart_link.h"
#include "version.h"

#ifdef CONFIG_PHAROS_IMC_DATAGRAMS
#include "threads/imc_link.h"
#endif

LOG_MODULE_REGISTER(pharos);

struct thread_row {
	const char *name;
	int priority;
	k_thread_entry_t run;
	void *argument;
	enum supervisor_watch watch; /* SUPERVISOR_WATCHES: not watched */
	enum startup_step device;    /* only if it has started; STARTUP_STEPS: always */
	k_thread_stack_t *stack;
	size_t stack_size;
	struct k_thread *thread;
};

/* Declares a thread's stack and control block. */
#define THREAD(name_, stack_size_)                                                                 \
	static K_THREAD_STACK_DEFINE(name_##_stack, stack_size_);                                  \
	static struct k_thread name_##_thread

/* A row of the table. */
#define ROW(name_, priority_, run_, argument_, watch_, device_)                                    \
	{                                                                                          \
		.name = #name_, .priority = (priority_), .run = (run_), .argument = (argument_),   \
		.watch = (watch_), .device = (device_), .stack = name_##_stack,                    \
		.stack_size = K_THREAD_STACK_SIZEOF(name_##_stack), .thread = &name_##_thread,     \
	}

#define UART_LINK_THREAD(i_, _) THREAD(uart_link##i_, CONFIG_PHAROS_LINK_STACK_SIZE)
#define UART_LINK_ROW(i_, _)                                                                       \
	ROW(uart_link##i_, 4, uart_link_run, (void *)i_, SUPERVISOR_UART_LINK##i_,                 \
	    STARTUP_UART_LINK##i_)

THREAD(supervisor, CONFIG_PHAROS_SUPERVISOR_STACK_SIZE);
THREAD(thermal, CONFIG_PHAROS_THERMAL_STACK_SIZE);
THREAD(command, CONFIG_PHAROS_COMMAND_STACK_SIZE);
LISTIFY(UART_LINKS_MAX, UART_LINK_THREAD, (;));
#ifdef CONFIG_CAN
THREAD(can_link, CONFIG_PHAROS_LINK_STACK_SIZE);
#endif
#ifdef CONFIG_PHAROS_IMC_DATAGRAMS
THREAD(imc_link, CONFIG_PHAROS_LINK_STACK_SIZE);
#endif

static const struct thread_row supervisor =
	ROW(supervisor, 0, supervisor_run, NULL, SUPERVISOR_WATCHES, STARTUP_STEPS);

static const struct thread_row threads[] = {
	ROW(thermal, 1, thermal_thread_run, NULL, SUPERVISOR_THERMAL, STARTUP_STEPS),
	ROW(command, 3, command_run, NULL, SUPERVISOR_COMMAND, STARTUP_STEPS),
	LISTIFY(UART_LINKS_MAX, UART_LINK_ROW, (, )),
#ifdef CONFIG_CAN
	ROW(can_link, 4, can_link_run, NULL, SUPERVISOR_CAN_LINK, STARTUP_CAN_LINK),
#endif
#ifdef CONFIG_PHAROS_IMC_DATAGRAMS
	ROW(imc_link, 4, imc_link_run, NULL, SUPERVISOR_IMC_LINK, STARTUP_IMC_LINK),
#endif
};

static void start(const struct thread_row *row)
{
	if (row->device != STARTUP_STEPS && startup_result(row->device) != 0) {
		return;
	}
	if (row->watch != SUPERVISOR_WATCHES) {
		supervisor_watch(row->watch);
	}
	/* K_FOREVER: until the next line but one */
	k_thread_create(row->thread, row->stack, row->stack_size, row->run, row->argument, NULL,
	                NULL, row->priority, 0, K_FOREVER);
	k_thread_name_set(row->thread, row->name);
	k_thread_start(row->thread);
}

/* Before our drivers touch their hardware, so that whatever hangs from then on is bitten. */
static int supervise(void)
{
	reset_cause_init();
	supervisor_watch(SUPERVISOR_START);
	start(&supervisor);
	return 0;
}

SYS_INIT(supervise, POST_KERNEL, CONFIG_PHAROS_SUPERVISOR_INIT_PRIORITY);
BUILD_ASSERT(CONFIG_PHAROS_SUPERVISOR_INIT_PRIORITY < CONFIG_PHAROS_DRIVERS_INIT_PRIORITY,
             "a driver that hangs is bitten");

int main(void)
{
	char cause[RESET_CAUSE_TEXT_MAX];

	reset_cause_text(cause);
	LOG_INF("Pharos %s, reset cause: %s", PHAROS_VERSION, cause);
	devices_start();
	command_init();
	for (size_t i = 0; i < ARRAY_SIZE(threads); i++) {
		start(&threads[i]);
	}
	storage_start();
	inputs_init();
	trial_start();
	supervisor_unwatch(SUPERVISOR_START);
	return 0;
}
