/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "shell_internal.h"

#ifdef CONFIG_SHELL_THREAD_PRIORITY_OVERRIDE
#define SHELL_PRIORITY CONFIG_SHELL_THREAD_PRIORITY
#else
#define SHELL_PRIORITY K_LOWEST_APPLICATION_THREAD_PRIO
#endif

/* Bytes taken from the transport at once. */
#define READ_MAX 64

BUILD_ASSERT(sizeof(((struct shell_ctx *)0)->history) < INT16_MAX, "history_at counts its lines");

static void transport_event(enum shell_transport_evt evt, void *context)
{
	struct shell_ctx *ctx = context;

	k_sem_give(evt == SHELL_TRANSPORT_EVT_RX_RDY ? &ctx->rx_ready : &ctx->tx_ready);
}

/* Runs a line. The caller holds exec_mtx and wr_mtx; wr_mtx is free while the command runs, since a
 * command may let another thread print.
 */
static int run(const struct shell *sh, const char *line)
{
	struct shell_ctx *ctx = sh->ctx;
	int rc;

	(void)strcpy(ctx->command, line);
	ctx->executing = true;
	(void)k_mutex_unlock(&ctx->wr_mtx);
	rc = shell_execute(sh);
	(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
	ctx->executing = false;
	return rc;
}

static bool is_blank(const char *line)
{
	return line[strspn(line, " ")] == '\0';
}

static void line_complete(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;

	if (ctx->overflow) {
		ctx->executing = true;
		shell_error(sh, "line longer than %d characters: not executed",
		            CONFIG_SHELL_CMD_BUFF_SIZE - 1);
		ctx->executing = false;
		ctx->ret_val = -ENOEXEC;
		shell_edit_reset(sh);
	} else if (is_blank(ctx->line)) {
		shell_edit_reset(sh);
	} else {
		if (shell_is_terminal(sh)) {
			shell_history_add(ctx, ctx->line);
		}
		/* saved_line is free outside history, and command is split while it runs. */
		(void)strcpy(ctx->saved_line, ctx->line);
		shell_edit_reset(sh);
		ctx->ret_val = run(sh, ctx->saved_line);
	}
	if (shell_is_terminal(sh) && ctx->bypass == NULL) {
		shell_out_fresh_line(sh);
		shell_edit_show(sh);
	}
}

static void pass_by(const struct shell *sh, uint8_t *data, size_t len)
{
	struct shell_ctx *ctx = sh->ctx;

	(void)k_mutex_lock(&ctx->exec_mtx, K_FOREVER);
	ctx->executing = true;
	ctx->bypass(sh, data, len);
	ctx->executing = false;
	if (ctx->bypass == NULL && shell_is_terminal(sh)) {
		(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
		shell_out_fresh_line(sh);
		shell_edit_show(sh);
		(void)k_mutex_unlock(&ctx->wr_mtx);
	}
	(void)k_mutex_unlock(&ctx->exec_mtx);
}

static void take_byte(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	(void)k_mutex_lock(&ctx->exec_mtx, K_FOREVER);
	(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
	if (shell_edit_byte(sh, byte)) {
		line_complete(sh);
	}
	(void)k_mutex_unlock(&ctx->wr_mtx);
	(void)k_mutex_unlock(&ctx->exec_mtx);
}

static void shell_thread(void *p1, void *p2, void *p3)
{
	const struct shell *sh = p1;
	struct shell_ctx *ctx = sh->ctx;
	char bytes[READ_MAX];

	if (shell_is_terminal(sh)) {
		(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
		shell_out_fresh_line(sh);
		shell_edit_show(sh);
		shell_edit_ask_width(sh);
		(void)k_mutex_unlock(&ctx->wr_mtx);
	}
	for (;;) {
		size_t count = 0;

		(void)sh->iface->api->read(sh->iface, bytes, sizeof(bytes), &count);
		for (size_t i = 0; i < count; i++) {
			if (ctx->bypass != NULL) {
				pass_by(sh, (uint8_t *)&bytes[i], count - i);
				break;
			}
			take_byte(sh, bytes[i]);
		}
		if (count == 0) {
			(void)k_sem_take(&ctx->rx_ready, K_FOREVER);
		}
	}
}

int shell_init(const struct shell *sh, const void *transport_config,
               struct shell_backend_config_flags cfg_flags, bool log_backend,
               uint32_t init_log_level)
{
	struct shell_ctx *ctx = sh->ctx;
	int rc;

	if (ctx->state != SHELL_STATE_UNINITIALIZED) {
		return -EALREADY;
	}
	(void)k_mutex_init(&ctx->exec_mtx);
	(void)k_mutex_init(&ctx->wr_mtx);
	(void)k_sem_init(&ctx->rx_ready, 0, 1);
	(void)k_sem_init(&ctx->tx_ready, 0, 1);
	ctx->cfg = cfg_flags;
	ctx->log_backend = log_backend;
	ctx->prompt = sh->default_prompt;
	ctx->columns = CONFIG_SHELL_DEFAULT_TERMINAL_WIDTH;
	ctx->line_start = true;
	ctx->key_state = SHELL_KEY_PLAIN;
	shell_edit_reset(sh);
	rc = sh->iface->api->init(sh->iface, transport_config, transport_event, ctx);
	if (rc != 0) {
		return rc;
	}
	ctx->state = SHELL_STATE_ACTIVE;
	ctx->tid = k_thread_create(sh->thread, sh->stack, CONFIG_SHELL_STACK_SIZE, shell_thread,
	                           (void *)sh, NULL, NULL, SHELL_PRIORITY, 0, K_NO_WAIT);
	(void)k_thread_name_set(ctx->tid, sh->thread_name);
	return 0;
}

bool shell_ready(const struct shell *sh)
{
	return sh->ctx->state == SHELL_STATE_ACTIVE;
}

int shell_execute_cmd(const struct shell *sh, const char *cmd)
{
	struct shell_ctx *ctx = sh->ctx;
	int rc;

	if (ctx->state != SHELL_STATE_ACTIVE || strlen(cmd) >= sizeof(ctx->command)) {
		return -ENOEXEC;
	}
	(void)k_mutex_lock(&ctx->exec_mtx, K_FOREVER);
	if (ctx->executing) {
		(void)k_mutex_unlock(&ctx->exec_mtx);
		return -EDEADLK;
	}
	(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
	shell_out_begin(sh);
	rc = run(sh, cmd);
	ctx->ret_val = rc;
	shell_out_end(sh);
	(void)k_mutex_unlock(&ctx->wr_mtx);
	(void)k_mutex_unlock(&ctx->exec_mtx);
	return rc;
}

void shell_set_bypass(const struct shell *sh, shell_bypass_cb_t bypass)
{
	sh->ctx->bypass = bypass;
}

int shell_get_return_value(const struct shell *sh)
{
	return sh->ctx->ret_val;
}

int shell_prompt_change(const struct shell *sh, const char *prompt)
{
	if (prompt == NULL) {
		return -EINVAL;
	}
	(void)k_mutex_lock(&sh->ctx->wr_mtx, K_FOREVER);
	shell_out_begin(sh);
	sh->ctx->prompt = prompt;
	shell_out_end(sh);
	(void)k_mutex_unlock(&sh->ctx->wr_mtx);
	return 0;
}

static int set_flag(const struct shell *sh, size_t offset, bool val)
{
	bool before;
	bool *flag;

	if (sh == NULL) {
		return -EINVAL;
	}
	flag = (bool *)((char *)&sh->ctx->cfg + offset);
	(void)k_mutex_lock(&sh->ctx->wr_mtx, K_FOREVER);
	before = *flag;
	shell_out_begin(sh);
	*flag = val;
	shell_out_end(sh);
	(void)k_mutex_unlock(&sh->ctx->wr_mtx);
	return before;
}

int shell_echo_set(const struct shell *sh, bool val)
{
	return set_flag(sh, offsetof(struct shell_backend_config_flags, echo), val);
}

int shell_use_colors_set(const struct shell *sh, bool val)
{
	return set_flag(sh, offsetof(struct shell_backend_config_flags, use_colors), val);
}

int shell_use_vt100_set(const struct shell *sh, bool val)
{
	return set_flag(sh, offsetof(struct shell_backend_config_flags, use_vt100), val);
}
