/* SPDX-License-Identifier: Apache-2.0 */
/* --test: the host's side of ztest. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "host/error.h"
#include "host/module.h"
#include "host/prng.h"
#include "ztest_native.h"

enum {
	SELECTED_MAX = 64
};

static const char *selected[SELECTED_MAX];
static size_t selected_count;

static int parse_test(const char *value, struct host_error *error)
{
	if (selected_count == SELECTED_MAX) {
		return host_error_set(error, "more than %d of them", SELECTED_MAX);
	}
	selected[selected_count++] = value;
	return 0;
}

static const struct host_option options[] = {
	{"test", "SUITE[::NAME]", "run this suite or test only; may be repeated", parse_test},
	{0},
};

HOST_MODULE(ztest_module) = {
	.name = "tests",
	.order = HOST_ORDER_BASE,
	.options = options,
};

bool ztest_native_selected(const char *suite, const char *test)
{
	const size_t length = strlen(suite);

	for (size_t i = 0; i < selected_count; i++) {
		const char *const rest = selected[i] + length;

		if (strncmp(selected[i], suite, length) == 0 &&
		    (rest[0] == '\0' ||
		     (strncmp(rest, "::", 2) == 0 && strcmp(rest + 2, test) == 0))) {
			return true;
		}
	}
	return selected_count == 0;
}

const char *ztest_native_replay(void)
{
	static char text[32];

	(void)snprintf(text, sizeof(text), " --seed %" PRIu64, prng_seed());
	return text;
}
