/* SPDX-License-Identifier: Apache-2.0 */
#include "shell_peer.h"

#include <string.h>
#include <unistd.h>

#include "host/wire.h"

enum shell_peer shell_peer_of(const char *name)
{
	const struct wire *wire = wire_find(name);

	if (wire == NULL || wire->type == &wire_none) {
		return SHELL_PEER_NONE;
	}
	if (wire->type == &wire_pty || wire->type == &wire_serial) {
		return SHELL_PEER_TERMINAL;
	}
	if (wire->type == &wire_stdio && isatty(STDIN_FILENO) && isatty(STDOUT_FILENO)) {
		return SHELL_PEER_CONSOLE;
	}
	return SHELL_PEER_PROGRAM;
}
