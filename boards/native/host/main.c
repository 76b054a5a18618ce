/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The process's entry. The application's own main() is a thread of the device; the build renames
 * that (boards/native/board.cmake), so that both can be called main.
 */
#include "host/carry.h"
#include "host/module.h"
#include "kernel/port.h"

#undef main

int main(int argc, char *argv[])
{
	carry_load(argv);
	options_parse(argc, argv);
	if (host_start() != 0) {
		host_stop();
		return 1;
	}
	carry_done();
	kernel_boot();
}
