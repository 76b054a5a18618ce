/* SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>
#include <zephyr/sys/reboot.h>

/* Printing may wait for the UART, and threads must not come or go meanwhile: so the list is taken
 * first. */
#define THREADS_MAX 32

struct thread_row {
	char name[CONFIG_THREAD_MAX_NAME_LEN];
	char state[K_THREAD_STATE_MAX_LENGTH];
	int priority;
	size_t stack_size;
	size_t stack_unused;
};

struct thread_rows {
	struct thread_row row[THREADS_MAX];
	size_t count; /* may be more than there are rows */
};

static struct thread_rows rows;
/* Two shells may ask at the same time. */
static K_MUTEX_DEFINE(rows_lock);

static void add_row(const struct k_thread *thread, void *user_data)
{
	const k_tid_t tid = (k_tid_t)thread;
	struct thread_rows *all = user_data;
	struct thread_row *row;

	if (all->count++ >= THREADS_MAX) {
		return;
	}
	row = &all->row[all->count - 1];
	memset(row, 0, sizeof(*row));
	(void)strncpy(row->name, k_thread_name_get(tid), sizeof(row->name) - 1);
	(void)k_thread_state_str(tid, row->state, sizeof(row->state));
	row->priority = k_thread_priority_get(tid);
	row->stack_size = thread->stack_info.size;
	if (k_thread_stack_space_get(thread, &row->stack_unused) != 0) {
		row->stack_unused = row->stack_size;
	}
}

static void take_rows(void)
{
	rows.count = 0;
	k_thread_foreach(add_row, &rows);
}

static void print_left_out(const struct shell *sh)
{
	if (rows.count > THREADS_MAX) {
		shell_warn(sh, "and %zu more", rows.count - THREADS_MAX);
	}
}

static int cmd_threads(const struct shell *sh, size_t argc, char **argv)
{
	(void)k_mutex_lock(&rows_lock, K_FOREVER);
	take_rows();
	shell_print(sh, "%-16s %4s  %-12s %s", "name", "prio", "state", "stack used / size");
	for (size_t i = 0; i < MIN(rows.count, (size_t)THREADS_MAX); i++) {
		const struct thread_row *row = &rows.row[i];

		shell_print(sh, "%-16s %4d  %-12s %zu / %zu", row->name, row->priority,
		            row->state[0] == '\0' ? "ready" : row->state,
		            row->stack_size - row->stack_unused, row->stack_size);
	}
	print_left_out(sh);
	(void)k_mutex_unlock(&rows_lock);
	return 0;
}

static int cmd_stacks(const struct shell *sh, size_t argc, char **argv)
{
	(void)k_mutex_lock(&rows_lock, K_FOREVER);
	take_rows();
	for (size_t i = 0; i < MIN(rows.count, (size_t)THREADS_MAX); i++) {
		const struct thread_row *row = &rows.row[i];
		const size_t used = row->stack_size - row->stack_unused;

		shell_print(sh, "%-16s size %zu, unused %zu, used %zu (%zu %%)", row->name,
		            row->stack_size, row->stack_unused, used,
		            row->stack_size == 0 ? 0 : used * 100 / row->stack_size);
	}
	print_left_out(sh);
	(void)k_mutex_unlock(&rows_lock);
	return 0;
}

static int cmd_uptime(const struct shell *sh, size_t argc, char **argv)
{
	shell_print(sh, "Uptime: %" PRId64 " ms", k_uptime_get());
	return 0;
}

static int cmd_reboot(const struct shell *sh, size_t argc, char **argv)
{
	sys_reboot(strcmp(argv[0], "warm") == 0 ? SYS_REBOOT_WARM : SYS_REBOOT_COLD);
}

SHELL_STATIC_SUBCMD_SET_CREATE(reboot_commands,
	SHELL_CMD_ARG(cold, NULL, "As after power-on", cmd_reboot, 1, 0),
	SHELL_CMD_ARG(warm, NULL, "The same here", cmd_reboot, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_STATIC_SUBCMD_SET_CREATE(kernel_commands,
	SHELL_CMD(reboot, &reboot_commands, "Reset the board", NULL),
	SHELL_CMD_ARG(stacks, NULL, "Use of the stacks", cmd_stacks, 1, 0),
	SHELL_CMD_ARG(threads, NULL, "Threads", cmd_threads, 1, 0),
	SHELL_CMD_ARG(uptime, NULL, "Time since this boot", cmd_uptime, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_CMD_REGISTER(kernel, &kernel_commands, "The kernel", NULL);
