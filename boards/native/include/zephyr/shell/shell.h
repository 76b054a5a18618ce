/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shell: commands that a module registers, and shells that run them. The subset of Zephyr's API
 * that the native port has; semantics are those of Zephyr 3.4.
 *
 * A command is a word, or several (`light set`), and its arguments:
 *
 *	static int cmd_on(const struct shell *sh, size_t argc, char **argv)
 *	{
 *		shell_print(sh, "on");
 *		return 0;
 *	}
 *	SHELL_STATIC_SUBCMD_SET_CREATE(light_commands,
 *		SHELL_CMD_ARG(on, NULL, "Turn the lamp on", cmd_on, 1, 0),
 *		SHELL_SUBCMD_SET_END);
 *	SHELL_CMD_REGISTER(light, &light_commands, "The lamp", NULL);
 *
 * argv[0] is the word that names the command; the last word with a command function wins. Words are
 * split at blanks; 'single' and "double" quotes keep blanks, a backslash keeps the next character.
 * `-h` or `--help` as any word after the first prints the help instead.
 * `mandatory` counts argv[0]; with mandatory 0 the number of arguments is not checked.
 *
 * A command runs in its shell's thread, or in the caller of shell_execute_cmd(). Printing: from any
 * thread, not from interrupts.
 */
#ifndef ZEPHYR_SHELL_SHELL_H
#define ZEPHYR_SHELL_SHELL_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/kernel.h>
#include <zephyr/sys/iterable_sections.h>
#include <zephyr/sys/util.h>

/* As `optional`: what follows the mandatory words is one argument, exactly as it was typed. */
#define SHELL_OPT_ARG_RAW        0xFE
/* As `optional`: any number of words. */
#define SHELL_OPT_ARG_CHECK_SKIP 0xFF
/* Highest number of optional words that can be checked. */
#define SHELL_OPT_ARG_MAX        0xFD

/* What a command returns after it has only printed its help. */
#define SHELL_CMD_HELP_PRINTED 1

struct shell;
struct shell_static_entry;

/* Returns 0, or SHELL_CMD_HELP_PRINTED, or -errno (-EINVAL: bad argument, -ENOEXEC: not executed).
 * argv[argc] is NULL.
 */
typedef int (*shell_cmd_handler)(const struct shell *sh, size_t argc, char **argv);

/* Fills `entry` with the idx-th subcommand, in alphabetical order; entry->syntax NULL: no more. */
typedef void (*shell_dynamic_get)(size_t idx, struct shell_static_entry *entry);

/* Takes len bytes as they come from the transport, in the shell's thread. */
typedef void (*shell_bypass_cb_t)(const struct shell *sh, uint8_t *data, size_t len);

union shell_cmd_entry {
	shell_dynamic_get dynamic_get;
	const struct shell_static_entry *entry; /* ends with syntax NULL */
};

struct shell_static_args {
	uint8_t mandatory;
	uint8_t optional;
};

struct shell_static_entry {
	const char *syntax; /* NULL: end of a set; "": disabled */
	const char *help;
	const union shell_cmd_entry *subcmd;
	shell_cmd_handler handler;
	struct shell_static_args args;
};

#define SHELL_EXPR_CMD_ARG(_expr, _syntax, _subcmd, _help, _handler, _mand, _opt)                  \
	{                                                                                          \
		.syntax = (_expr)                                                                  \
			? STRINGIFY(_syntax) : "",                                                 \
		                    .help = (_expr) ? (const char *)(_help) : NULL,                \
		                    .subcmd = (_expr) ? (const union shell_cmd_entry *)(_subcmd)   \
		                                      : NULL,                                      \
		                    .handler = (_expr) ? (shell_cmd_handler)(_handler) : NULL,     \
		                    .args = {.mandatory = (_mand), .optional = (_opt)},            \
	}
#define SHELL_EXPR_CMD(_expr, _syntax, _subcmd, _help, _handler)                                   \
	SHELL_EXPR_CMD_ARG(_expr, _syntax, _subcmd, _help, _handler, 0, 0)

#define SHELL_CMD_ARG(_syntax, _subcmd, _help, _handler, _mand, _opt)                              \
	SHELL_EXPR_CMD_ARG(1, _syntax, _subcmd, _help, _handler, _mand, _opt)
#define SHELL_CMD(_syntax, _subcmd, _help, _handler)                                               \
	SHELL_CMD_ARG(_syntax, _subcmd, _help, _handler, 0, 0)

/* _flag: a Kconfig option, as it stands. */
#define SHELL_COND_CMD_ARG(_flag, _syntax, _subcmd, _help, _handler, _mand, _opt)                  \
	SHELL_EXPR_CMD_ARG(IS_ENABLED(_flag), _syntax, _subcmd, _help, _handler, _mand, _opt)
#define SHELL_COND_CMD(_flag, _syntax, _subcmd, _help, _handler)                                   \
	SHELL_COND_CMD_ARG(_flag, _syntax, _subcmd, _help, _handler, 0, 0)

#define SHELL_SUBCMD_SET_END                                                                       \
	{                                                                                          \
		.syntax = NULL                                                                     \
	}

/* A set of subcommands; ends with SHELL_SUBCMD_SET_END. */
#define SHELL_STATIC_SUBCMD_SET_CREATE(_name, ...)                                                 \
	static const struct shell_static_entry shell_##_name[] = {__VA_ARGS__};                    \
	static const union shell_cmd_entry _name = {.entry = shell_##_name}

/* A set of subcommands that a function enumerates. */
#define SHELL_DYNAMIC_CMD_CREATE(_name, _get)                                                      \
	static const TYPE_SECTION_ITERABLE(union shell_cmd_entry, _name, shell_dynamic_subcmds,    \
	                                   _name) = {.dynamic_get = (_get)}

/* A root command. Each has a name of its own. */
#define SHELL_CMD_ARG_REGISTER(_syntax, _subcmd, _help, _handler, _mand, _opt)                     \
	static const struct shell_static_entry shell_entry_##_syntax =                             \
		SHELL_CMD_ARG(_syntax, _subcmd, _help, _handler, _mand, _opt);                     \
	static const TYPE_SECTION_ITERABLE(union shell_cmd_entry, shell_cmd_##_syntax,             \
	                                   shell_root_cmds, shell_cmd_##_syntax) = {               \
		.entry = &shell_entry_##_syntax}
#define SHELL_CMD_REGISTER(_syntax, _subcmd, _help, _handler)                                      \
	SHELL_CMD_ARG_REGISTER(_syntax, _subcmd, _help, _handler, 0, 0)

/* --- printing ------------------------------------------------------------------------------- */

enum shell_vt100_color {
	SHELL_VT100_COLOR_BLACK,
	SHELL_VT100_COLOR_RED,
	SHELL_VT100_COLOR_GREEN,
	SHELL_VT100_COLOR_YELLOW,
	SHELL_VT100_COLOR_BLUE,
	SHELL_VT100_COLOR_MAGENTA,
	SHELL_VT100_COLOR_CYAN,
	SHELL_VT100_COLOR_WHITE,
	SHELL_VT100_COLOR_DEFAULT,
};

#define SHELL_NORMAL  SHELL_VT100_COLOR_DEFAULT
#define SHELL_INFO    SHELL_VT100_COLOR_GREEN
#define SHELL_OPTION  SHELL_VT100_COLOR_CYAN
#define SHELL_WARNING SHELL_VT100_COLOR_YELLOW
#define SHELL_ERROR   SHELL_VT100_COLOR_RED

/* As printf(). A text longer than CONFIG_SHELL_PRINTF_BUFF_SIZE is cut and ends in "...". Outside a
 * command the text appears above the line that is being typed.
 */
void shell_fprintf(const struct shell *sh, enum shell_vt100_color color, const char *fmt, ...)
	__attribute__((format(printf, 3, 4)));
void shell_vfprintf(const struct shell *sh, enum shell_vt100_color color, const char *fmt,
                    va_list args) __attribute__((format(printf, 3, 0)));

/* With a line end. */
#define shell_info(_sh, _ft, ...)  shell_fprintf(_sh, SHELL_INFO, _ft "\n", ##__VA_ARGS__)
#define shell_print(_sh, _ft, ...) shell_fprintf(_sh, SHELL_NORMAL, _ft "\n", ##__VA_ARGS__)
#define shell_warn(_sh, _ft, ...)  shell_fprintf(_sh, SHELL_WARNING, _ft "\n", ##__VA_ARGS__)
#define shell_error(_sh, _ft, ...) shell_fprintf(_sh, SHELL_ERROR, _ft "\n", ##__VA_ARGS__)

#define SHELL_HEXDUMP_BYTES_IN_LINE 16

/* One line: offset, up to 16 bytes, the same as text. */
void shell_hexdump_line(const struct shell *sh, unsigned int offset, const uint8_t *data,
                        size_t len);
void shell_hexdump(const struct shell *sh, const uint8_t *data, size_t len);

/* --- a shell -------------------------------------------------------------------------------- */

enum shell_transport_evt {
	SHELL_TRANSPORT_EVT_RX_RDY,
	SHELL_TRANSPORT_EVT_TX_RDY,
};

typedef void (*shell_transport_handler_t)(enum shell_transport_evt evt, void *context);

struct shell_transport;

/* read() and write() take what they can, put the number of bytes in *cnt, never wait, and return 0
 * or -errno. The handler may be called from interrupts.
 */
struct shell_transport_api {
	int (*init)(const struct shell_transport *transport, const void *config,
	            shell_transport_handler_t evt_handler, void *context);
	int (*uninit)(const struct shell_transport *transport);
	/* blocking_tx: from now on write() itself waits for the device, without interrupts. */
	int (*enable)(const struct shell_transport *transport, bool blocking_tx);
	int (*write)(const struct shell_transport *transport, const void *data, size_t length,
	             size_t *cnt);
	int (*read)(const struct shell_transport *transport, void *data, size_t length,
	            size_t *cnt);
};

struct shell_transport {
	const struct shell_transport_api *api;
	void *ctx;
};

/* echo and use_vt100 together mean a terminal: prompt, line editing, history, completion. Without
 * either, lines are executed as they come, and nothing but what commands print is sent.
 */
struct shell_backend_config_flags {
	bool echo;
	bool use_colors;
	bool use_vt100;
};

#define SHELL_DEFAULT_BACKEND_CONFIG_FLAGS                                                         \
	{                                                                                          \
		.echo = true, .use_colors = true, .use_vt100 = true                                \
	}

enum shell_state {
	SHELL_STATE_UNINITIALIZED,
	SHELL_STATE_INITIALIZED,
	SHELL_STATE_ACTIVE,
	SHELL_STATE_PANIC,
};

/* Output: '\n' is the transport's newline as it stands, or CR LF. A terminal gets CR LF always. */
enum shell_flag {
	SHELL_FLAG_CRLF_DEFAULT = 1,
	SHELL_FLAG_OLF_CRLF = 2,
};

enum shell_key_state {
	SHELL_KEY_PLAIN,
	SHELL_KEY_ESCAPE, /* after ESC */
	SHELL_KEY_CSI,    /* after ESC [ */
	SHELL_KEY_SS3,    /* after ESC O */
};

/* The shell's own state. A command reads nothing of it. */
struct shell_ctx {
	enum shell_state state;
	struct shell_backend_config_flags cfg;
	const char *prompt;
	struct shell_static_entry active_cmd; /* the command whose function runs */
	bool executing;
	bool log_backend; /* lines of log go through this shell */
	int ret_val;
	shell_bypass_cb_t bypass; /* NULL: bytes are keys */
	void (*leave)(void);      /* Ctrl-D on an empty line: ends the program; NULL: nothing */

	/* the line being typed */
	char line[CONFIG_SHELL_CMD_BUFF_SIZE]; /* always terminated */
	uint16_t len;
	uint16_t pos;
	bool overflow;   /* something typed did not fit */
	bool shown;      /* prompt and line are on the screen */
	bool line_start; /* the last thing sent ended a line */
	uint16_t columns;
	uint16_t cursor_row; /* of the cursor, below the prompt's row */

	/* keys */
	enum shell_key_state key_state;
	uint16_t key_args[2];
	uint8_t key_arg_count;
	char last_newline;

	/* history: lines with their terminators, oldest first */
	char history[CONFIG_SHELL_HISTORY_BUFFER];
	uint16_t history_len;
	int16_t history_at; /* lines back from the newest; -1: not in history */
	char saved_line[CONFIG_SHELL_CMD_BUFF_SIZE]; /* what was typed before going back */

	char command[CONFIG_SHELL_CMD_BUFF_SIZE]; /* the line being executed, split in place */
	char text[CONFIG_SHELL_PRINTF_BUFF_SIZE];

	struct k_mutex exec_mtx; /* command, active_cmd, executing; taken before wr_mtx */
	struct k_mutex wr_mtx;   /* output, and the line being typed */
	struct k_sem rx_ready;
	struct k_sem tx_ready;
	k_tid_t tid;
};

struct shell {
	const char *default_prompt;
	const struct shell_transport *iface;
	struct shell_ctx *ctx;
	enum shell_flag shell_flag;
	const char *thread_name;
	struct k_thread *thread;
	k_thread_stack_t *stack;
};

/* Zephyr's log queue arguments are taken and not needed: the log has one queue. */
#define SHELL_DEFINE(_name, _prompt, _transport_iface, _log_queue_size, _log_timeout, _shell_flag) \
	static struct shell_ctx _name##_ctx;                                                       \
	static struct k_thread _name##_thread;                                                     \
	static K_THREAD_STACK_DEFINE(_name##_stack, CONFIG_SHELL_STACK_SIZE);                      \
	static const STRUCT_SECTION_ITERABLE(shell, _name) = {                                     \
		.default_prompt = (_prompt),                                                       \
		.iface = (_transport_iface),                                                       \
		.ctx = &_name##_ctx,                                                               \
		.shell_flag = (_shell_flag),                                                       \
		.thread_name = #_name,                                                             \
		.thread = &_name##_thread,                                                         \
		.stack = _name##_stack,                                                            \
	}

/* Opens the transport and starts the shell's thread. log_backend: its lines of log go through this
 * shell. init_log_level is taken and not needed: levels are set at build time. 0, -EALREADY, or
 * what the transport returned.
 */
int shell_init(const struct shell *sh, const void *transport_config,
               struct shell_backend_config_flags cfg_flags, bool log_backend,
               uint32_t init_log_level);

/* True when the shell executes commands. */
bool shell_ready(const struct shell *sh);

/* Runs a command line in the caller's thread and returns what the command did; -ENOEXEC: empty, too
 * long, not terminated, or no such command. -EDEADLK: called from a command of the same shell.
 */
int shell_execute_cmd(const struct shell *sh, const char *cmd);

/* Prints the help of the running command and of its subcommands. From commands only. */
void shell_help(const struct shell *sh);

/* From now on bytes go to bypass as they come, with no echo, no prompt and no history; NULL: they
 * are keys again. From a command, or from bypass itself.
 */
void shell_set_bypass(const struct shell *sh, shell_bypass_cb_t bypass);

/* What the last command returned. */
int shell_get_return_value(const struct shell *sh);

/* prompt stays the caller's. -EINVAL: NULL. */
int shell_prompt_change(const struct shell *sh, const char *prompt);

/* Return what was set before, or -EINVAL: sh is NULL. */
int shell_echo_set(const struct shell *sh, bool val);
int shell_use_colors_set(const struct shell *sh, bool val);
int shell_use_vt100_set(const struct shell *sh, bool val);

#endif
