/* SPDX-License-Identifier: Apache-2.0 */
#include "host/guard.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/hardware.h"
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

/* Each in a process of its own: a bus that hangs holds up no other output. Without processes, in
 * the order in which they were added. */
static _Noreturn void make_all_safe(void)
{
	for (const struct guard_output *output = outputs; output != NULL; output = output->next) {
		pid_t child;

		if (!output->is_open) {
			continue;
		}
		child = fork();
		if (child <= 0) {
			output->make_safe();
		}
		if (child == 0) {
			_exit(0);
		}
	}
	_exit(0);
}

/* The pipe closes with the last thread of the other process, and one in a transfer of the kernel's
 * may outlive a kill for long. So the end of its main thread, which forks this one, counts too. */
static _Noreturn void watch(int in, int out, pid_t parent)
{
	struct signalfd_siginfo died = {0};
	struct pollfd waits[2] = {{.fd = in, .events = POLLIN}, {.events = POLLIN}};
	sigset_t signals;
	char byte;

	/* what ends the other process, such as Ctrl-C, is not to end this one first */
	sigfillset(&signals);
	sigprocmask(SIG_BLOCK, &signals, NULL);
	setsid();
	close_others(in, out);
	sigemptyset(&signals);
	sigaddset(&signals, SIGUSR1);
	waits[1].fd = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
	prctl(PR_SET_PDEATHSIG, SIGUSR1);
	if (getppid() != parent) {
		make_all_safe();
	}
	prctl(PR_SET_NAME, "pharos-guard"); /* also says that it is ready */
	do {
		(void)poll(waits, 2, -1);
		(void)read(waits[1].fd, &died, sizeof(died));
	} while (died.ssi_pid != (uint32_t)parent &&
	         (waits[0].revents == 0 || read(in, &byte, 1) != 0));
	make_all_safe();
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

/* Ends a guard that is not to act, or that has been ended. */
static void forget(void)
{
	if (guard == 0) {
		return;
	}
	loop_remove(&ends);
	close(ends.fd);
	(void)kill(guard, SIGKILL);
	while (waitpid(guard, NULL, 0) < 0 && errno == EINTR) {
	}
	close(alive);
	guard = 0;
}

static void close_both(const int ends_of_pipe[2])
{
	close(ends_of_pipe[0]);
	close(ends_of_pipe[1]);
}

/* Of the main thread: the guard acts at the end of the thread that has forked it. */
static int start_guard(void)
{
	const pid_t parent = getpid();
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
		watch(to_guard[0], from_guard[1], parent);
	}
	close(to_guard[0]);
	close(from_guard[1]);
	/* only now: at no instant is there none */
	forget();
	guard = child;
	alive = to_guard[1];
	ends.fd = from_guard[0];
	ends.ready = on_end;
	loop_add(&ends, EPOLLIN);
	return 0;
}

void guard_add(struct guard_output *output)
{
	struct guard_output **end = &outputs;

	while (*end != NULL) {
		end = &(*end)->next;
	}
	output->next = NULL;
	*end = output;
}

int guard_renew(void)
{
	int rc = 0;

	if (clock_is_virtual() || hardware_is_only_off()) {
		return 0;
	}
	loop_timer_stop(&retry);
	if (is_wanted()) {
		rc = start_guard();
	} else {
		forget();
	}
	if (rc != 0) {
		host_say("no new process to guard the outputs: %s; trying again", strerror(-rc));
		loop_timer_start(&retry, RETRY_MS);
	}
	return rc;
}

/* Somebody has ended it. */
static void on_end(struct loop_source *source, uint32_t events)
{
	(void)source;
	(void)events;
	forget();
	(void)guard_renew();
}

static void on_retry(struct loop_timer *timer)
{
	(void)timer;
	(void)guard_renew();
}

void guard_stop(void)
{
	loop_timer_stop(&retry);
	forget();
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
