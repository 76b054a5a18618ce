/* SPDX-License-Identifier: Apache-2.0 */
#include "port.h"
#include "sched.h"

extern int main(void);

#define IDLE_STACK_SIZE 1024

static struct k_thread main_thread, idle_thread;
static K_THREAD_STACK_DEFINE(main_stack, CONFIG_MAIN_STACK_SIZE);
static K_THREAD_STACK_DEFINE(idle_stack, IDLE_STACK_SIZE);

static void run_entry(const struct init_entry *entry)
{
	if (entry->dev != NULL) {
		device_init_result(entry->dev, entry->init_fn.dev(entry->dev));
	} else {
		(void)entry->init_fn.sys();
	}
}

/* Entries are few and boot comes once: a pass for each priority that occurs, in link order. */
static void run_level(enum init_level level)
{
	int next = 0;

	while (next >= 0) {
		const int priority = next;

		next = -1;
		TYPE_SECTION_FOREACH(const struct init_entry, init_entry, entry)
		{
			if (entry->level != level) {
				continue;
			}
			if (entry->priority == priority) {
				run_entry(entry);
			} else if (entry->priority > priority &&
			           (next < 0 || entry->priority < next)) {
				next = entry->priority;
			}
		}
	}
}

static void run_main(void *p1, void *p2, void *p3)
{
	ARG_UNUSED(p1);
	ARG_UNUSED(p2);
	ARG_UNUSED(p3);

	run_level(INIT_LEVEL_POST_KERNEL);
	run_level(INIT_LEVEL_APPLICATION);
	threads_start_static();
	(void)main();
	main_thread.base.user_options &= (uint8_t)~K_ESSENTIAL;
}

void kernel_boot(void)
{
	sched_init();
	mem_init();
	native_cpu.irq_locked = true;
	run_level(INIT_LEVEL_EARLY);
	run_level(INIT_LEVEL_PRE_KERNEL_1);
	run_level(INIT_LEVEL_PRE_KERNEL_2);
	(void)k_thread_create(&main_thread, main_stack, K_THREAD_STACK_SIZEOF(main_stack), run_main,
	                      NULL, NULL, NULL, CONFIG_MAIN_THREAD_PRIORITY, K_ESSENTIAL,
	                      K_NO_WAIT);
	(void)k_thread_name_set(&main_thread, "main");
	(void)k_thread_create(&idle_thread, idle_stack, K_THREAD_STACK_SIZEOF(idle_stack),
	                      sched_idle, NULL, NULL, NULL, K_IDLE_PRIO, K_ESSENTIAL, K_NO_WAIT);
	(void)k_thread_name_set(&idle_thread, "idle");
	sched_start(&main_thread);
}
