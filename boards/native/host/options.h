/* SPDX-License-Identifier: Apache-2.0 */
/* An option of the command line, of which each module brings a table, and how values are read. */
#ifndef NATIVE_HOST_OPTIONS_H_
#define NATIVE_HOST_OPTIONS_H_

#include <stddef.h>
#include <stdint.h>

#include "host/error.h"

struct host_option {
	const char *name; /* without the dashes */
	const char *arg;  /* what --help calls the value; NULL: takes none */
	const char *help; /* one or more lines, split at \n */
	/* 0, or -1 with a reason in *error. value is NULL when arg is; it stays valid for the whole
	 * run. */
	int (*parse)(const char *value, struct host_error *error);
};

/* "500us", "500ms", "2s", "1.5h", "24h", "1d". 0, or -1 with a reason. */
int parse_duration_us(const char *text, uint64_t *us, struct host_error *error);

/* A decimal number in low…high, nothing else around it. 0, or -1 with a reason. */
int parse_number(const char *text, uint64_t low, uint64_t high, uint64_t *number,
                 struct host_error *error);

#endif
