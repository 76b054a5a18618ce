/* SPDX-License-Identifier: Apache-2.0 */
/*
 * To be preloaded: a PWM's bus that hangs or fails. The environment names files:
 *   SLOW_BUS        while it is there, a duty is not written
 *   SLOW_BUS_FAILS  if it is there, the next duty is not written, with an error; and it is removed
 *   SLOW_BUS_LOG    what has been written: "<monotonic time in us> <attribute> <number>", a line
 *                   each, of duty_cycle and enable; -1: that was with an error
 *   NO_FORK         while it is there, there are no new processes
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static int is_there(const char *name)
{
	const char *path = getenv(name);

	return path != NULL && access(path, F_OK) == 0;
}

/* The name of the file in path, if it is an attribute of a PWM; else NULL. */
static const char *attribute_of(int fd, char path[256])
{
	const char *name;
	char link[32];
	ssize_t length;

	(void)snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
	length = readlink(link, path, 255);
	path[length > 0 ? length : 0] = '\0';
	name = basename(path);
	return strcmp(name, "duty_cycle") == 0 || strcmp(name, "enable") == 0 ? name : NULL;
}

static void put_log(const char *name, const void *data, size_t size)
{
	const char *path = getenv("SLOW_BUS_LOG");
	FILE *log = path != NULL ? fopen(path, "ae") : NULL;
	struct timespec now;

	if (log != NULL) {
		clock_gettime(CLOCK_MONOTONIC, &now);
		(void)fprintf(log, "%lld %s %.*s", now.tv_sec * 1000000ll + now.tv_nsec / 1000,
		              name, (int)size, (const char *)data);
		(void)fclose(log);
	}
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t offset)
{
	const struct timespec delay = {0, 10000000};
	char path[256];
	const char *name = attribute_of(fd, path);

	if (name != NULL && strcmp(name, "duty_cycle") == 0) {
		while (is_there("SLOW_BUS")) {
			nanosleep(&delay, NULL);
		}
		if (is_there("SLOW_BUS_FAILS")) {
			(void)unlink(getenv("SLOW_BUS_FAILS"));
			put_log(name, "-1\n", 3);
			errno = EREMOTEIO;
			return -1;
		}
	}
	if (name != NULL) {
		put_log(name, data, size);
	}
	return syscall(SYS_pwrite64, fd, data, size, offset);
}

pid_t fork(void)
{
	pid_t (*real)(void);

	if (is_there("NO_FORK")) {
		errno = EAGAIN;
		return -1;
	}
	*(void **)&real = dlsym(RTLD_NEXT, "fork");
	return real();
}
