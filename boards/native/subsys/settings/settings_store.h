/* SPDX-License-Identifier: Apache-2.0 */
/* What the native settings store tells about itself. */
#ifndef SETTINGS_STORE_H
#define SETTINGS_STORE_H

#include "settings_records.h"

struct settings_store_status {
	const char *path; /* NULL: in memory */
	size_t used;      /* bytes of the content */
	size_t live;      /* of which bytes are of use */
	struct settings_records_stats stats;
};

void settings_store_status(struct settings_store_status *status);

/* Forgets what is in RAM, as a reset does: the next settings_subsys_init() opens the store anew.
 * Tests. */
void settings_store_close(void);

#endif
