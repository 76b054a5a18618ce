/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The process's entry. The application's own main() is a thread of the device; the build renames
 * that (boards/native/board.cmake), so that both can be called main.
 */
#include <fcntl.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/command_line.h"
#include "host/hardware.h"
#include "host/module.h"
#include "kernel/port.h"

#undef main

/* Started without them, a socket would become standard output; no descriptor of ours is 0, either.
 */
static void open_standard(void)
{
	for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
		if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0) {
			_exit(1);
		}
	}
}

int main(int argc, char *argv[])
{
	open_standard();
	int status;

	carry_load(argv);
	command_line_parse(argc, argv);
	if (hardware_is_only_off()) {
		host_only_outputs();
	}
	status = host_start();
	if (status != 0 || hardware_is_only_off()) {
		host_stop();
		return status;
	}
	carry_done();
	kernel_boot();
}
