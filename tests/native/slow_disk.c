/* SPDX-License-Identifier: Apache-2.0 */
/* To be preloaded: a disk that takes SLOW_DISK_MS for each fdatasync(), which SLOW_DISK_LOG tells.
 */
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static void tell(const char *text)
{
	const int fd = open(getenv("SLOW_DISK_LOG"), O_WRONLY | O_CREAT | O_APPEND, 0600);

	if (write(fd, text, strlen(text)) < 0) {
		abort();
	}
	close(fd);
}

int fdatasync(int fd)
{
	const long ms = atol(getenv("SLOW_DISK_MS"));
	const struct timespec delay = {ms / 1000, ms % 1000 * 1000000};

	(void)fd;
	tell("begin\n");
	nanosleep(&delay, NULL);
	tell("end\n");
	return 0;
}
