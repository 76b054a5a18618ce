/* SPDX-License-Identifier: Apache-2.0 */
/*
 * imc_codec FILE TIMES: the rate at which the stream finds and decodes the packets in FILE, given
 * to it in chunks as a socket gives them, and at which the same messages are encoded. Prints
 * packets in one pass, and nanoseconds per packet in and out.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/types.h>
#include <time.h>

#include "core/assert.h"
#include "proto/imc/stream.h"

#undef main /* the native board renames the application's; this program has its own */

#define STREAM_MAX  (4u << 20)
#define CHUNK       512u
#define PACKETS_MAX 64u

static struct imc_stream stream;
static struct imc_packet packets[PACKETS_MAX];

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

static size_t decode(const uint8_t *bytes, size_t length)
{
	struct imc_stream_packet found;
	size_t count = 0;

	while (length > 0) {
		const size_t size = length < CHUNK ? length : CHUNK;
		const size_t taken = imc_stream_write(&stream, bytes, size);

		bytes += taken;
		length -= taken;
		while (imc_stream_next(&stream, &found)) {
			count += imc_parse(found.bytes, &packets[count % PACKETS_MAX]) == IMC_OK;
		}
	}
	return count;
}

static size_t encode(size_t count)
{
	static uint8_t bytes[IMC_PACKET_MAX];
	size_t total = 0;

	for (size_t i = 0; i < count; i++) {
		total += imc_encode(&packets[i % PACKETS_MAX], bytes, sizeof(bytes));
	}
	return total;
}

/* What is encoded again points into the stream itself, not into its window. */
static void keep_first(const uint8_t *bytes, size_t length)
{
	size_t used = 0;
	size_t size;

	for (size_t i = 0;
	     i < PACKETS_MAX && imc_verify(bytes + used, length - used, &size) == IMC_OK; i++) {
		(void)imc_parse(bytes + used, &packets[i]);
		used += size;
	}
}

int main(int argc, char *argv[])
{
	static uint8_t bytes[STREAM_MAX];
	FILE *const file = argc == 3 ? fopen(argv[1], "rb") : NULL;

	if (file == NULL) {
		(void)fprintf(stderr, "imc_codec: give a readable FILE and how many TIMES\n");
		return 2;
	}

	const size_t length = fread(bytes, 1, sizeof(bytes), file);
	const unsigned long times = strtoul(argv[2], NULL, 10);
	size_t count = 0;

	(void)fclose(file);
	imc_stream_init(&stream);

	double begin = now_s();

	for (unsigned long i = 0; i < times; i++) {
		count = decode(bytes, length);
	}

	const double in_s = now_s() - begin;
	size_t total = 0;

	keep_first(bytes, length);
	begin = now_s();
	for (unsigned long i = 0; i < times; i++) {
		total += encode(count);
	}

	const double out_s = now_s() - begin;
	const double all = (double)count * (double)times;

	printf("%zu %.2f %.2f\n", total > 0 ? count : 0, in_s / all * 1e9, out_s / all * 1e9);
	return EXIT_SUCCESS;
}
