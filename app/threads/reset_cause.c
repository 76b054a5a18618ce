/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/reset_cause.h"

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>
#include <zephyr/sys/util.h>

#define BLAME_MAGIC 0x70486172u
#define BLAME_MAX   16

/* Survives a reset, but not the loss of power: then the magic is wrong. */
static __noinit struct {
	uint32_t magic;
	char thread[BLAME_MAX];
} blame;

static uint32_t cause;
static bool blamed;

static const struct {
	uint32_t flag;
	const char *name;
} names[] = {
	{RESET_WATCHDOG, "watchdog"},  {RESET_CPU_LOCKUP, "fatal error"},
	{RESET_BROWNOUT, "brown-out"}, {RESET_POR, "power-on"},
	{RESET_SOFTWARE, "software"},  {RESET_PIN, "reset pin"},
	{RESET_DEBUG, "debugger"},
};

void reset_cause_init(void)
{
	if (hwinfo_get_reset_cause(&cause) != 0) {
		cause = 0;
	}
	hwinfo_clear_reset_cause();
	blamed = blame.magic == BLAME_MAGIC;
	blame.magic = 0;
	blame.thread[BLAME_MAX - 1] = '\0';
}

void reset_cause_blame(const char *thread)
{
	if (thread == NULL) {
		blame.magic = 0;
		return;
	}
	snprintk(blame.thread, sizeof(blame.thread), "%s", thread);
	blame.magic = BLAME_MAGIC;
}

void reset_cause_text(char text[RESET_CAUSE_TEXT_MAX])
{
	const char *name = "unknown";

	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		if ((cause & names[i].flag) != 0) {
			name = names[i].name;
			break;
		}
	}
	/* without a watchdog the supervisor resets the board itself */
	if (blamed && (cause & (RESET_WATCHDOG | RESET_SOFTWARE)) != 0) {
		snprintk(text, RESET_CAUSE_TEXT_MAX, "%s (thread %s stalled)", name, blame.thread);
	} else {
		snprintk(text, RESET_CAUSE_TEXT_MAX, "%s", name);
	}
}
