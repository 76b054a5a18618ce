/* SPDX-License-Identifier: Apache-2.0 */
#include "host/guard.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/say.h"

enum {
	RETRY_MS = 500
};

static struct guard_output *outputs;
static pid_t guard;             /* 0: there is none */
static int alive = -1;          /* closes with this process: then the guard acts */
static struct loop_source ends; /* closes with the guard */
static struct loop_timer retry;

/* --- the guard's process ------------------------------------------------------------------------
 */

static bool is_kept(int fd, const char *target)
{
	for (const struct guard_output *output = outputs; output != NULL; output = output->next) {
		if (output->is_open && output->keeps(fd, target)) {
			return true;
		}
	}
	return false;
}

static void close_others(int in, int out)
{
	DIR *folder = opendir("/proc/self/fd");
	const struct dirent *entry;

	if (folder == NULL) {
		return;
	}
	while ((entry = readdir(folder)) != NULL) {
		const int fd = atoi(entry->d_name);
		char target[64];
		const ssize_t length =
			readlinkat(dirfd(folder), entry->d_name, target, sizeof(target) - 1);

		if (length < 0 || fd == in || fd == out || fd == dirfd(folder)) {
			continue;
		}
		target[length] = '\0';
		if (!is_kept(fd, target)) {
			close(fd);
		}
	}
	closedir(folder);
}

static _Noreturn void watch(int in, int out)
{
	sigset_t all;
	char byte;

	/* what ends the other process, such as Ctrl-C, is not to end this one first */
	sigfillset(&all);
	sigprocmask(SIG_BLOCK, &all, NULL);
	setsid();
	close_others(in, out);
	prctl(PR_SET_NAME, "pharos-guard"); /* also says that it is ready */
	while (read(in, &byte, 1) != 0) {
	}
	for (const struct guard_output *output = outputs; output != NULL; output = output->next) {
		if (output->is_open) {
			output->make_safe();
		}
	}
	_exit(0);
}

/* --- this process -------------------------------------------------------------------------------
 */

static void on_end(struct loop_source *source, uint32_t events);

static bool is_wanted(void)
{
	for (const struct guard_output *output = outputs; output != NULL; output = output->next) {
		if (output->is_open) {
			return true;
		}
	}
	return false;
}

static void close_both(const int ends_of_pipe[2])
{
	close(ends_of_pipe[0]);
	close(ends_of_pipe[1]);
}

static int start_guard(void)
{
	int to_guard[2];
	int from_guard[2];
	pid_t child;

	if (pipe2(to_guard, O_CLOEXEC) != 0) {
		return -errno;
	}
	if (pipe2(from_guard, O_CLOEXEC) != 0) {
		const int error = errno;

		close_both(to_guard);
		return -error;
	}
	child = fork();
	if (child < 0) {
		const int error = errno;

		close_both(to_guard);
		close_both(from_guard);
		return -error;
	}
	if (child == 0) {
		close(to_guard[1]);
		close(from_guard[0]);
		watch(to_guard[0], from_guard[1]);
	}
	close(to_guard[0]);
	close(from_guard[1]);
	guard = child;
	alive = to_guard[1];
	ends.fd = from_guard[0];
	ends.ready = on_end;
	loop_add(&ends, EPOLLIN);
	return 0;
}

/* Ends a guard that is not to act, or that has been ended. */
static void forget(pid_t pid, int its_alive)
{
	if (pid == 0) {
		return;
	}
	(void)kill(pid, SIGKILL);
	while (waitpid(pid, NULL, 0) < 0 && errno == EINTR) {
	}
	close(its_alive);
}

void guard_add(struct guard_output *output)
{
	output->next = outputs;
	outputs = output;
}

int guard_renew(void)
{
	const pid_t old = guard;
	const int its_alive = alive;
	int rc = 0;

	if (clock_is_virtual()) {
		return 0;
	}
	if (old != 0) {
		loop_remove(&ends);
		close(ends.fd);
		guard = 0;
	}
	/* the new one first: at no instant is there none */
	if (is_wanted()) {
		rc = start_guard();
	}
	forget(old, its_alive);
	return rc;
}

static void renew_or_retry(void)
{
	const int rc = guard_renew();

	if (rc != 0) {
		host_say("no process to guard the lamp: %s; trying again", strerror(-rc));
		loop_timer_start(&retry, RETRY_MS);
	}
}

/* Somebody has ended it. */
static void on_end(struct loop_source *source, uint32_t events)
{
	(void)source;
	(void)events;
	renew_or_retry();
}

static void on_retry(struct loop_timer *timer)
{
	(void)timer;
	renew_or_retry();
}

void guard_stop(void)
{
	loop_timer_stop(&retry);
	if (guard != 0) {
		loop_remove(&ends);
		close(ends.fd);
		forget(guard, alive);
		guard = 0;
	}
}

static int start(void)
{
	retry.fire = on_retry;
	return 0;
}

/* Before the outputs' modules start, after they have stopped. */
HOST_MODULE(guard_module) = {
	.name = "guard",
	.order = HOST_ORDER_BOARD - 1,
	.drives = true,
	.start = start,
	.save = guard_stop,
	.stop = guard_stop,
};
