/* SPDX-License-Identifier: Apache-2.0 */
#include "host/crash.h"

#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

enum {
	STACK_SIZE = 64 * 1024
};

static const int fatal[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGQUIT, SIGHUP};

static int terminal = -1;
static struct termios terminal_settings;
static struct sigaction before[sizeof(fatal) / sizeof(fatal[0])];
static char stack[STACK_SIZE];

void crash_restore(void)
{
	const int error = errno;

	if (terminal >= 0) {
		tcsetattr(terminal, TCSANOW, &terminal_settings);
		terminal = -1;
	}
	errno = error;
}

/* Then whoever was there before (a sanitizer, the default) gets the same signal again. */
static void on_fatal(int number, siginfo_t *info, void *context)
{
	(void)context;
	crash_restore();
	for (size_t i = 0; i < sizeof(fatal) / sizeof(fatal[0]); i++) {
		if (fatal[i] == number) {
			sigaction(number, &before[i], NULL);
		}
	}
	/* A fault repeats by itself on return; what a process or the terminal sent does not. */
	if (info->si_code <= 0 || number == SIGHUP || number == SIGQUIT) {
		raise(number);
	}
}

void crash_restore_terminal(int fd, const struct termios *settings)
{
	static bool installed;
	const struct sigaction action = {.sa_sigaction = on_fatal,
	                                 .sa_flags = SA_ONSTACK | SA_SIGINFO};
	const stack_t alternate = {.ss_sp = stack, .ss_size = sizeof(stack)};
	stack_t current;

	terminal_settings = *settings;
	terminal = fd;
	if (installed) {
		return;
	}
	installed = true;
	/* A sanitizer brings its own; threads run on small stacks, so one is needed. */
	if (sigaltstack(NULL, &current) == 0 && (current.ss_flags & SS_DISABLE) != 0) {
		sigaltstack(&alternate, NULL);
	}
	for (size_t i = 0; i < sizeof(fatal) / sizeof(fatal[0]); i++) {
		sigaction(fatal[i], &action, &before[i]);
	}
	atexit(crash_restore);
}
