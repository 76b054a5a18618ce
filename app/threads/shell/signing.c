/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for MAVLink's message signing: signing key, off, status.
 *
 * The key is typed after the command, unseen, so that it is neither on the screen nor among the
 * lines typed before. No command shows it.
 */
#include <errno.h>
#include <string.h>

#include <zephyr/shell/shell.h>
#include <zephyr/sys/util.h>

#include <pharos/compat.h>

#include "core/decimal.h"
#include "threads/clock.h"
#include "threads/mavlink_node.h"
#include "threads/shell/call.h"

#define KEY_DIGITS     (2 * MAVLINK_SIGNING_KEY_BYTES)
#define STAMP_DECIMALS 5 /* a timestamp counts 10 us */
#define CTRL_C         0x03
#define BACKSPACE      0x08
#define DELETE         0x7f

/* What is being typed; the shell's thread only. */
static struct {
	uint64_t timestamp;
	size_t count;
	char digits[KEY_DIGITS];
} entry;

static uint64_t timestamp_now(void)
{
	return mavlink_signing_timestamp(&mavlink_node_endpoint()->signing, clock_now_us());
}

static int set_key(struct pharos_device *device, void *argument)
{
	struct mavlink_signing_record *const record = argument;

	if (record->timestamp == 0) {
		record->timestamp = timestamp_now();
	}
	mavlink_node_set_key(record);
	memset(record, 0, sizeof(*record));
	return 0;
}

/* --- the key ---------------------------------------------------------------------------------- */

static void key_entered(const struct shell *sh)
{
	struct mavlink_signing_record record = {.timestamp = entry.timestamp};
	const size_t bytes = entry.count == KEY_DIGITS ? hex2bin(entry.digits, KEY_DIGITS,
	                                                         record.key, sizeof(record.key))
	                                               : 0;
	uint8_t any = 0;

	memset(entry.digits, 0, sizeof(entry.digits));
	for (size_t i = 0; i < sizeof(record.key); i++) {
		any |= record.key[i];
	}
	if (bytes != sizeof(record.key)) {
		shell_error(sh, "not %d hex digits; nothing changed", KEY_DIGITS);
	} else if (any == 0) {
		shell_error(sh, "that would be no key (see: signing off); nothing changed");
	} else {
		if (shell_call(sh, set_key, &record, NULL)) {
			shell_print(sh, "signing is on");
		}
	}
	memset(&record, 0, sizeof(record));
}

static void type(uint8_t byte)
{
	if (byte == BACKSPACE || byte == DELETE) {
		entry.count -= entry.count > 0;
		return;
	}
	if (entry.count < KEY_DIGITS) {
		entry.digits[entry.count] = (char)byte;
	}
	entry.count++;
}

/* Bytes after `signing key`, until the line ends. */
static void take_bytes(SHELL_BYPASS_PARAMS(const struct shell *sh, uint8_t *data, size_t len))
{
	for (size_t i = 0; i < len; i++) {
		const bool ends = data[i] == '\r' || data[i] == '\n';

		if (data[i] == CTRL_C) {
			shell_set_bypass(sh, NULL);
			memset(entry.digits, 0, sizeof(entry.digits));
			shell_print(sh, "nothing changed");
			return;
		}
		/* the rest of the command's own line end comes first */
		if (ends && entry.count > 0) {
			shell_set_bypass(sh, NULL);
			key_entered(sh);
			return;
		}
		if (!ends) {
			type(data[i]);
		}
	}
}

static int cmd_signing_key(const struct shell *sh, size_t argc, char **argv)
{
	int64_t unix_s = 0;

	if (argc > 1 && (!decimal_parse_exact(argv[1], 0, &unix_s) ||
	                 unix_s < (int64_t)MAVLINK_TIMESTAMP_EPOCH_S ||
	                 unix_s > (int64_t)(MAVLINK_TIMESTAMP_EPOCH_S +
	                                    MAVLINK_TIMESTAMP_MAX / MAVLINK_TIMESTAMP_SECOND))) {
		shell_error(sh, "'%s' is not a Unix time between 2015 and 2104", argv[1]);
		return -EINVAL;
	}
	entry.count = 0;
	entry.timestamp =
		argc > 1 ? ((uint64_t)unix_s - MAVLINK_TIMESTAMP_EPOCH_S) * MAVLINK_TIMESTAMP_SECOND
			 : 0;
	shell_print(sh, "%d hex digits, not shown; Ctrl-C leaves all as it is:", KEY_DIGITS);
	shell_set_bypass(sh, take_bytes);
	return 0;
}

static int cmd_signing_off(const struct shell *sh, size_t argc, char **argv)
{
	struct mavlink_signing_record none = {0};

	if (!shell_call(sh, set_key, &none, NULL)) {
		return -EAGAIN;
	}
	shell_print(sh, "signing is off");
	return 0;
}

/* --- status ----------------------------------------------------------------------------------- */

struct status {
	struct mavlink_signing_stats stats;
	uint64_t timestamp;
	uint8_t secure_links;
	uint8_t streams;
	bool on;
	bool locked;
};

static int copy_status(struct pharos_device *device, void *argument)
{
	const struct mavlink_endpoint *const endpoint = mavlink_node_endpoint();
	struct status *const status = argument;

	status->stats = endpoint->signing.stats;
	status->timestamp = timestamp_now();
	status->secure_links = endpoint->config.secure_links;
	status->streams = endpoint->signing.stream_count;
	status->on = endpoint->signing.on;
	status->locked = endpoint->signing.locked;
	return 0;
}

static int cmd_signing_status(const struct shell *sh, size_t argc, char **argv)
{
	char text[DECIMAL_TEXT_MAX];
	struct status now;

	if (!shell_call(sh, copy_status, &now, NULL)) {
		return -EAGAIN;
	}
	(void)decimal_print(
		text,
		(int64_t)(now.timestamp + MAVLINK_TIMESTAMP_EPOCH_S * MAVLINK_TIMESTAMP_SECOND),
		STAMP_DECIMALS);
	shell_print(sh, "%-16s%s", "key",
	            now.locked ? "lost: locked until signing key, or signing off"
	            : now.on   ? "set"
	                       : "none");
	shell_print(sh, "%-16s%s s, Unix time", "timestamp", text);
	shell_print(sh, "%-16s%u of %d", "streams", now.streams, MAVLINK_SIGNING_STREAMS_MAX);
	for (uint32_t i = 0; i < MAVLINK_SIGNING_VERDICTS; i++) {
		shell_print(sh, "%-16s%u",
		            mavlink_signing_verdict_name((enum mavlink_signing_verdict)i),
		            now.stats.verdicts[i]);
	}
	shell_print(sh, "%-16s%u", "sent signed", now.stats.signed_frames);
	shell_print(sh, "%-16s%u obeyed, %u refused; on the links of mask %u", "SETUP_SIGNING",
	            now.stats.setups, now.stats.setups_refused, now.secure_links);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	signing_commands,
	SHELL_CMD_ARG(key, NULL, "[UNIX_TIME]  set the key, which is asked for", cmd_signing_key, 1,
		      1),
	SHELL_CMD_ARG(off, NULL, "Forget the key", cmd_signing_off, 1, 0),
	SHELL_CMD_ARG(status, NULL, "Is there a key, and what came of received frames",
		      cmd_signing_status, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(signing, &signing_commands, "MAVLink message signing", NULL);
