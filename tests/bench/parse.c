/* SPDX-License-Identifier: Apache-2.0 */
/*
 * parse FILE TIMES: the rate at which the framer verifies the stream in FILE, given to it in chunks
 * as a UART gives them. Prints MB/s (10^6 bytes) and the number of frames found in one pass.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/types.h>
#include <time.h>

#include "core/assert.h"
#include "proto/mavlink/framer.h"

#undef main /* the native board renames the application's; this program has its own */

#define STREAM_MAX (4u << 20)
#define CHUNK      64u

void pharos_assert_failed(const char *file, int line)
{
	(void)fprintf(stderr, "%s:%d: assertion failed\n", file, line);
	abort();
}

static double now_s(void)
{
	struct timespec now;

	(void)clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static uint32_t parse(struct mavlink_framer *framer, const uint8_t *bytes, size_t length)
{
	const uint32_t before = framer->stats.frames;
	struct mavlink_frame frame;

	while (length > 0) {
		const size_t size = length < CHUNK ? length : CHUNK;
		const size_t taken = mavlink_framer_write(framer, bytes, size);

		bytes += taken;
		length -= taken;
		while (mavlink_framer_next(framer, &frame)) {
		}
	}
	return framer->stats.frames - before;
}

int main(int argc, char *argv[])
{
	static uint8_t stream[STREAM_MAX];
	static struct mavlink_framer framer;
	FILE *const file = argc == 3 ? fopen(argv[1], "rb") : NULL;

	if (file == NULL) {
		(void)fprintf(stderr, "parse: give a readable FILE and how many TIMES\n");
		return 2;
	}

	const size_t length = fread(stream, 1, sizeof(stream), file);
	const unsigned long times = strtoul(argv[2], NULL, 10);
	uint32_t frames = 0;

	(void)fclose(file);
	mavlink_framer_init(&framer);

	const double begin = now_s();

	for (unsigned long i = 0; i < times; i++) {
		frames = parse(&framer, stream, length);
	}

	const double took = now_s() - begin;

	printf("%.1f %u\n", (double)length * (double)times * 1e-6 / took, (unsigned int)frames);
	return EXIT_SUCCESS;
}
