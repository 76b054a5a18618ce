/* SPDX-License-Identifier: Apache-2.0 */
#include "host/device_id.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/claim.h"
#include "host/clock.h"
#include "host/module.h"
#include "host/prng.h"

#define PLACES 1000u

static uint64_t told;
static uint64_t settings_id; /* 0: no settings file */

/* A place is claimed once, and goes along over resets. */
static struct {
	uint32_t number;
	int claim;
} place = {.claim = -1};

static uint64_t mix(uint64_t id, const char *text)
{
	struct prng prng = {.state = id};

	for (; *text != '\0'; text++) {
		prng.state = prng_next(&prng) ^ (uint8_t)*text;
	}
	return prng_next(&prng);
}

/* Of this machine: what systemd keeps, else its name. */
static uint64_t host_id(void)
{
	char text[64] = "";
	FILE *const file = fopen("/etc/machine-id", "re");

	if (file == NULL || fgets(text, sizeof(text), file) == NULL) {
		(void)gethostname(text, sizeof(text) - 1);
	}
	if (file != NULL) {
		(void)fclose(file);
	}
	text[strcspn(text, "\n")] = '\0';
	return mix(0, text);
}

static void take_place(void)
{
	char name[32];

	for (place.number = 0; place.claim < 0 && place.number < PLACES; place.number++) {
		(void)snprintf(name, sizeof(name), "/device id %u", place.number);
		place.claim = claim_name(name);
		if (place.claim >= 0) {
			return;
		}
	}
	place.number = (uint32_t)getpid(); /* all are taken, or there are no claims here */
}

uint64_t device_id(void)
{
	struct prng prng;
	uint64_t id = told;

	if (id == 0 && (clock_is_virtual() || prng_is_seeded())) {
		prng_init(&prng, "hwinfo");
		id = prng_next(&prng);
	} else if (id == 0 && settings_id != 0) {
		id = settings_id;
	} else if (id == 0) {
		char text[16];

		if (place.claim < 0) {
			take_place();
		}
		(void)snprintf(text, sizeof(text), "%u", place.number);
		id = mix(host_id(), text);
	}
	return id != 0 ? id : 1;
}

void device_id_keep_with(const char *path)
{
	char whole[PATH_MAX];

	if (realpath(path, whole) != NULL) {
		settings_id = mix(host_id(), whole);
	}
}

/* --- the module ------------------------------------------------------------------------------- */

static int parse_id(const char *value, struct host_error *error)
{
	char *end = NULL;

	errno = 0;
	told = isxdigit((unsigned char)value[0]) ? strtoull(value, &end, 16) : 0;
	if (told == 0 || errno != 0 || *end != '\0') {
		return host_error_set(error, "1 to 16 hexadecimal digits, not all 0");
	}
	return 0;
}

static const struct host_option options[] = {
	{"device-id", "HEX",
         "the chip's serial number (default: goes with the settings file;\nwithout one this host's "
         "first light has one, the second another;\nin virtual time or with --seed, of the seed)",
         parse_id},
	{0},
};

static int start(void)
{
	(void)carry_register("device id", &place, sizeof(place));
	return 0;
}

static void save(void)
{
	if (place.claim >= 0) {
		carry_fd(place.claim);
	}
}

HOST_MODULE(device_id_module) = {
	.name = "board",
	.order = HOST_ORDER_BASE,
	.options = options,
	.start = start,
	.save = save,
};
