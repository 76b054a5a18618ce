/* SPDX-License-Identifier: Apache-2.0 */
#include "gpio_guard_host.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

static pid_t guard; /* 0: there is none */
static int alive = -1;

/* Lines are anonymous inodes of the kernel: gpio-line, gpio-linehandle. */
static bool is_line(int folder, const char *name)
{
	char target[64];
	const ssize_t length = readlinkat(folder, name, target, sizeof(target) - 1);

	if (length < 0) {
		return false;
	}
	target[length] = '\0';
	return strstr(target, "gpio-line") != NULL;
}

/* Sockets and pipes that stayed open here would hide the end of the other process. */
static void close_others(int keep)
{
	DIR *folder = opendir("/proc/self/fd");
	const struct dirent *entry;

	if (folder == NULL) {
		return;
	}
	while ((entry = readdir(folder)) != NULL) {
		const int fd = atoi(entry->d_name);

		if (entry->d_name[0] != '.' && fd != keep && fd != dirfd(folder) &&
		    !is_line(dirfd(folder), entry->d_name)) {
			close(fd);
		}
	}
	closedir(folder);
}

static _Noreturn void watch(int other, void (*make_safe)(void))
{
	sigset_t all;
	char byte;

	/* what ends the other process, such as Ctrl-C, is not to end this one first */
	sigfillset(&all);
	sigprocmask(SIG_BLOCK, &all, NULL);
	setsid();
	close_others(other);
	prctl(PR_SET_NAME, "pharos-guard"); /* also says that it is ready */
	while (read(other, &byte, 1) != 0) {
	}
	make_safe();
	_exit(0);
}

int guard_start(void (*make_safe)(void))
{
	int ends[2];

	if (pipe2(ends, O_CLOEXEC) != 0) {
		return -errno;
	}
	guard = fork();
	if (guard < 0) {
		const int error = errno;

		guard = 0;
		close(ends[0]);
		close(ends[1]);
		return -error;
	}
	if (guard == 0) {
		close(ends[1]);
		watch(ends[0], make_safe);
	}
	close(ends[0]);
	alive = ends[1];
	return 0;
}

void guard_stop(void)
{
	if (guard == 0) {
		return;
	}
	close(alive);
	while (waitpid(guard, NULL, 0) < 0 && errno == EINTR) {
	}
	guard = 0;
}

bool guard_is_well(void)
{
	if (guard == 0 || waitpid(guard, NULL, WNOHANG) == 0) {
		return true;
	}
	close(alive);
	guard = 0;
	return false;
}
