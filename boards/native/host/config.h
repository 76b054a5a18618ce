/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A file of options: a line `NAME = VALUE` for each, `NAME = yes` or `no` for one that takes no
 * value; # begins a comment, and so does ; after a blank. A reset keeps what was read: a file that
 * was changed meanwhile counts from the next start of the process on.
 */
#ifndef NATIVE_HOST_CONFIG_H_
#define NATIVE_HOST_CONFIG_H_

#include "host/error.h"

/*
 * Calls take for each line; value stays valid for the whole run. 0; or -1 with a reason, which
 * names file, line and option: of the first line that cannot be read, or for which take says -1.
 */
int config_read(const char *path,
                int (*take)(const char *name, const char *value, struct host_error *error),
                struct host_error *error);

#endif
