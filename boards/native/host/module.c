/* SPDX-License-Identifier: Apache-2.0 */
#include "host/module.h"

#include <stdlib.h>
#include <string.h>

enum {
	MODULES_MAX = 32
};

/* Bounds of the section, from the linker. */
extern const struct host_module *const __start_host_module_table[];
extern const struct host_module *const __stop_host_module_table[];

static const struct host_module *sorted[MODULES_MAX];
static size_t sorted_count;
static size_t started;
static bool is_only_outputs;

static int compare(const void *a, const void *b)
{
	const struct host_module *left = *(const struct host_module *const *)a;
	const struct host_module *right = *(const struct host_module *const *)b;

	if (left->order != right->order) {
		return left->order < right->order ? -1 : 1;
	}
	return strcmp(left->name, right->name);
}

const struct host_module *const *host_modules(size_t *count)
{
	if (sorted_count == 0) {
		const size_t n = (size_t)(__stop_host_module_table - __start_host_module_table);

		if (n > MODULES_MAX) {
			abort();
		}
		memcpy(sorted, __start_host_module_table, n * sizeof(sorted[0]));
		qsort(sorted, n, sizeof(sorted[0]), compare);
		sorted_count = n;
	}
	*count = sorted_count;
	return sorted;
}

void host_only_outputs(void)
{
	size_t kept = 0;

	for (size_t i = 0; i < sorted_count; i++) {
		if (sorted[i]->drives) {
			sorted[kept++] = sorted[i];
		}
	}
	sorted_count = kept;
	is_only_outputs = true;
}

int host_start(void)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);
	int first = 0;

	for (started = 0; started < count; started++) {
		const int status = modules[started]->start != NULL ? modules[started]->start() : 0;

		if (status != 0 && first == 0) {
			first = status > 0 ? status : 1;
		}
		if (first != 0 && !is_only_outputs) {
			break;
		}
	}
	return first;
}

void host_up(void)
{
	for (size_t i = 0; i < started; i++) {
		if (sorted[i]->up != NULL) {
			sorted[i]->up();
		}
	}
}

void host_off(void)
{
	for (size_t i = started; i > 0; i--) {
		if (sorted[i - 1]->off != NULL) {
			sorted[i - 1]->off();
		}
	}
}

void host_save(void)
{
	for (size_t i = started; i > 0; i--) {
		if (sorted[i - 1]->save != NULL) {
			sorted[i - 1]->save();
		}
	}
}

void host_stop(void)
{
	/* A hook that ends the process itself must not run the others again. */
	while (started > 0) {
		started--;
		if (sorted[started]->stop != NULL) {
			sorted[started]->stop();
		}
	}
}
