/* SPDX-License-Identifier: Apache-2.0 */
/*
 * command COUNT: CPU time of one command, from bytes to the bytes of its acknowledgement, through
 * framer and endpoint. Prints nanoseconds unsigned, and with a signature to be checked and one to
 * be made. Rounds of both in turn; the least of the rounds, which others' load has disturbed least.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>

#include "core/assert.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/framer.h"
#include "proto/mavlink/illuminator_service.h"

#undef main /* the native board renames the application's; this program has its own */

#define ROUNDS    20
#define COUNT_MAX 1000000ul

void pharos_assert_failed(const char *file, int line)
{
	(void)fprintf(stderr, "%s:%d: assertion failed\n", file, line);
	abort();
}

struct stream {
	uint8_t *bytes;
	size_t length;
	unsigned long count;
};

static const struct mavlink_signing_record key = {.timestamp = 1, .key = {1, 2, 3}};
static struct pharos_device device;
static struct mavlink_illuminator service;
static struct mavlink_endpoint endpoint;
static struct mavlink_outbox out;
static struct mavlink_framer framer;

static double cpu_ns(void)
{
	struct timespec now;

	(void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

static void start(bool is_signed)
{
	static const struct mavlink_identity identity = {.vendor_name = "",
	                                                 .model_name = "",
	                                                 .software_version = "",
	                                                 .hardware_version = "",
	                                                 .serial_number = ""};
	const struct device_config device_config = {.gimbal = false};
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 1};

	params_init(&device.params);
	pharos_device_init(&device, 0, &device_config);
	mavlink_illuminator_init(&service, &device, 0, &identity);
	mavlink_endpoint_init(&endpoint, &config);
	mavlink_endpoint_add(&endpoint, 0, 243, &mavlink_illuminator_profile, &service);
	mavlink_framer_init(&framer);
	if (is_signed) {
		mavlink_endpoint_restore_key(&endpoint, 0, &key);
	}
}

/* ILLUMINATOR_ON_OFF over and over, each with a timestamp of its own if it is signed. */
static struct stream make(unsigned long count, bool is_signed)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 255, .component_id = 190, .has_signature = is_signed};
	const mavlink_command_long_t command = {.command = MAV_CMD_ILLUMINATOR_ON_OFF,
	                                        .param1 = 1,
	                                        .target_system = 1,
	                                        .target_component = 243};
	struct stream stream = {.bytes = malloc(count * MAVLINK_FRAME_MAX), .count = count};
	struct mavlink_signing ground;

	if (stream.bytes == NULL) {
		(void)fprintf(stderr, "command: no memory\n");
		exit(EXIT_FAILURE);
	}
	mavlink_signing_init(&ground, 0, &key);
	for (unsigned long i = 0; i < count; i++) {
		uint8_t *const at = stream.bytes + stream.length;
		size_t length = mavlink_frame_build(at, &sender, &kind, &command);

		length += is_signed ? mavlink_signing_sign(&ground, 0, at, length, 0) : 0;
		stream.length += length;
	}
	return stream;
}

/* All of it; nanoseconds per command. */
static double measure(const struct stream *stream, bool is_signed)
{
	const uint8_t *bytes = stream->bytes;
	size_t left = stream->length;
	unsigned long answers = 0;
	struct mavlink_frame frame;

	start(is_signed);

	const double begin = cpu_ns();

	while (left > 0) {
		const size_t taken = mavlink_framer_write(&framer, bytes, left);

		bytes += taken;
		left -= taken;
		while (mavlink_framer_next(&framer, &frame)) {
			mavlink_endpoint_receive(&endpoint, 0, 0, frame.bytes, frame.length, &out);
			answers += out.count;
		}
	}

	const double took = cpu_ns() - begin;

	if (answers != stream->count) {
		(void)fprintf(stderr, "command: %lu answers to %lu commands\n", answers,
		              stream->count);
		exit(EXIT_FAILURE);
	}
	return took / (double)stream->count;
}

int main(int argc, char *argv[])
{
	const unsigned long count = argc == 2 ? strtoul(argv[1], NULL, 10) : 0;
	double least[2] = {0, 0};

	if (count < ROUNDS || count > COUNT_MAX) {
		(void)fprintf(stderr, "command: COUNT %d…%lu\n", ROUNDS, COUNT_MAX);
		return 2;
	}

	const struct stream streams[2] = {make(count / ROUNDS, false), make(count / ROUNDS, true)};

	for (int round = 0; round < ROUNDS; round++) {
		for (int is_signed = 0; is_signed < 2; is_signed++) {
			const double ns = measure(&streams[is_signed], is_signed != 0);

			if (round == 0 || ns < least[is_signed]) {
				least[is_signed] = ns;
			}
		}
	}
	printf("%.1f %.1f\n", least[0], least[1]);
	return EXIT_SUCCESS;
}
