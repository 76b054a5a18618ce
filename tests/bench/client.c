/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures whatever answers MAVLink 2 frames over loopback UDP.
 *
 *   bench_client latency FROM TO ANSWER COUNT FRAME 1 [KEY TIMESTAMP]
 *           one at a time; prints p50 and p99 in ns
 *   bench_client rate FROM TO ANSWER COUNT FRAME WINDOW [KEY TIMESTAMP]
 *           WINDOW in flight; prints answers per second
 *
 * FROM, TO: the client's port and the server's. The same FROM each time is the same peer to a
 * server that remembers its peers. FRAME: the command, as hex. ANSWER: the message id that counts
 * as an answer (an echo: the command's own). Other messages (heartbeats, streams) are skipped. A
 * datagram may hold several frames. KEY, as hex: FRAME is a signed one, and each that is sent has
 * a timestamp of its own from TIMESTAMP on; they are signed before the measurement. An answer that
 * stays away for ANSWER_TIMEOUT_MS is counted as lost, printed last, and what is in flight is sent
 * anew.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/types.h>
#include <time.h>

/* Of the generated MAVLink library, as functions of this file. */
#define MAVLINK_HELPER static inline
#include <mavlink_sha256.h>

enum {
	FRAME_MAX = 280,
	DATAGRAM_MAX = 2048,
	WINDOW_MAX = 256,
	COUNT_MAX = 10000000,
	ANSWER_TIMEOUT_MS = 500,
	MAVLINK2_MAGIC = 0xFD,
	MAVLINK2_OVERHEAD = 12, /* header and checksum */
	MAVLINK2_SIGNED = 1,
	SIGNATURE_BYTES = 13, /* link id, timestamp, hash */
	TIMESTAMP_BYTES = 6,
	HASH_BYTES = 6,
	KEY_BYTES = 32,
};

struct client {
	int sock;
	uint32_t answer_id;
	uint8_t frame[FRAME_MAX];
	size_t frame_length;
	uint8_t *frames; /* to be sent in turn; NULL: always the one */
	size_t frame_count;
	size_t sent;
	unsigned long lost;
};

static uint64_t now_ns(void)
{
	struct timespec now;

	(void)clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static size_t parse_hex(const char *text, uint8_t *bytes, size_t size)
{
	size_t length = 0;

	while (length < size && text[0] != '\0' && text[1] != '\0') {
		const char pair[3] = {text[0], text[1], '\0'};

		bytes[length++] = (uint8_t)strtoul(pair, NULL, 16);
		text += 2;
	}
	return length;
}

/* Copies of the frame, each with the next timestamp, signed. */
static void sign_frames(struct client *self, size_t count, const char *key_text, uint64_t timestamp)
{
	const size_t hashed = self->frame_length - HASH_BYTES;
	uint8_t key[KEY_BYTES];

	self->frames = malloc(count * self->frame_length);
	if (self->frames == NULL || parse_hex(key_text, key, sizeof(key)) != sizeof(key)) {
		(void)fprintf(stderr, "bench_client: no memory, or KEY is not 32 bytes\n");
		exit(EXIT_FAILURE);
	}
	self->frame_count = count;
	for (size_t i = 0; i < count; i++, timestamp++) {
		uint8_t *const frame = self->frames + i * self->frame_length;
		mavlink_sha256_ctx context;

		memcpy(frame, self->frame, self->frame_length);
		memcpy(frame + hashed - TIMESTAMP_BYTES, &timestamp, TIMESTAMP_BYTES);
		mavlink_sha256_init(&context);
		mavlink_sha256_update(&context, key, sizeof(key));
		mavlink_sha256_update(&context, frame, (uint32_t)hashed);
		mavlink_sha256_final_48(&context, frame + hashed);
	}
}

/* What to send now. A run that loses so many that it has sent all is none. */
static uint8_t *next_frame(struct client *self)
{
	if (self->frames == NULL) {
		return self->frame;
	}
	if (self->sent == self->frame_count) {
		(void)fprintf(stderr, "bench_client: no signed frames left: too many were lost\n");
		exit(EXIT_FAILURE);
	}
	return self->frames + self->sent++ * self->frame_length;
}

/* How many answers the datagram holds. */
static unsigned int answers_in(const struct client *self, const uint8_t *data, size_t length)
{
	unsigned int count = 0;

	while (length >= MAVLINK2_OVERHEAD && data[0] == MAVLINK2_MAGIC) {
		const size_t size = MAVLINK2_OVERHEAD + (size_t)data[1] +
		                    ((data[2] & MAVLINK2_SIGNED) != 0 ? SIGNATURE_BYTES : 0);
		const uint32_t id = data[7] | (uint32_t)data[8] << 8 | (uint32_t)data[9] << 16;

		if (size > length) {
			break;
		}
		count += id == self->answer_id;
		data += size;
		length -= size;
	}
	return count;
}

/* One answer to one command; false: it was lost. */
static bool ask(struct client *self)
{
	uint8_t data[DATAGRAM_MAX];

	if (send(self->sock, next_frame(self), self->frame_length, 0) < 0) {
		return false;
	}
	for (;;) {
		const ssize_t size = recv(self->sock, data, sizeof(data), 0);

		if (size < 0) {
			return false;
		}
		if (answers_in(self, data, (size_t)size) > 0) {
			return true;
		}
	}
}

static int compare(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a;
	const uint64_t y = *(const uint64_t *)b;

	return (x > y) - (x < y);
}

static int measure_latency(struct client *self, unsigned long count)
{
	uint64_t *took = calloc(count, sizeof(*took));
	const unsigned long warm_up = count / 10;

	if (took == NULL) {
		return EXIT_FAILURE;
	}
	for (unsigned long i = 0; i < warm_up; i++) {
		(void)ask(self);
	}
	for (unsigned long i = 0; i < count; i++) {
		const uint64_t begin = now_ns();

		if (!ask(self)) {
			self->lost++;
		}
		took[i] = now_ns() - begin;
	}
	qsort(took, count, sizeof(*took), compare);
	printf("%llu %llu %lu\n", (unsigned long long)took[count / 2],
	       (unsigned long long)took[count - 1 - count / 100], self->lost);
	free(took);
	return EXIT_SUCCESS;
}

static void send_many(struct client *self, unsigned int count)
{
	struct iovec parts[WINDOW_MAX];
	struct mmsghdr messages[WINDOW_MAX];

	memset(messages, 0, sizeof(messages));
	for (unsigned int i = 0; i < count; i++) {
		parts[i] = (struct iovec){next_frame(self), self->frame_length};
		messages[i].msg_hdr.msg_iov = &parts[i];
		messages[i].msg_hdr.msg_iovlen = 1;
	}
	for (unsigned int sent = 0; sent < count;) {
		const int done = sendmmsg(self->sock, &messages[sent], count - sent, 0);

		if (done < 0) {
			if (errno == EINTR) {
				continue;
			}
			perror("bench_client: sendmmsg");
			exit(EXIT_FAILURE);
		}
		sent += (unsigned int)done;
	}
}

/* Waits for at least one datagram and takes all that are there; how many answers, 0: timed out. */
static unsigned int receive_many(struct client *self)
{
	static uint8_t data[WINDOW_MAX][DATAGRAM_MAX];
	struct iovec parts[WINDOW_MAX];
	struct mmsghdr messages[WINDOW_MAX];
	unsigned int answers = 0;

	memset(messages, 0, sizeof(messages));
	for (size_t i = 0; i < WINDOW_MAX; i++) {
		parts[i] = (struct iovec){.iov_base = data[i], .iov_len = DATAGRAM_MAX};
		messages[i].msg_hdr.msg_iov = &parts[i];
		messages[i].msg_hdr.msg_iovlen = 1;
	}
	while (answers == 0) {
		const int count = recvmmsg(self->sock, messages, WINDOW_MAX, MSG_WAITFORONE, NULL);

		if (count < 0) {
			return 0;
		}
		for (int i = 0; i < count; i++) {
			answers += answers_in(self, data[i], messages[i].msg_len);
		}
	}
	return answers;
}

static int measure_rate(struct client *self, unsigned long count, unsigned int window)
{
	unsigned long got = 0;
	unsigned int in_flight = window;
	const uint64_t begin = now_ns();

	send_many(self, window);
	while (got < count) {
		unsigned int fresh = receive_many(self);

		if (fresh == 0) {
			self->lost += in_flight;
			fresh = in_flight;
		} else {
			got += fresh;
		}
		/* Late answers to what was given up may make more answers than are in flight. */
		in_flight -= fresh < in_flight ? fresh : in_flight;
		send_many(self, window - in_flight);
		in_flight = window;
	}
	printf("%.0f %lu\n", (double)got * 1e9 / (double)(now_ns() - begin), self->lost);
	return EXIT_SUCCESS;
}

static int connect_from_to(unsigned long from, unsigned long to)
{
	const struct timeval timeout = {.tv_usec = ANSWER_TIMEOUT_MS * 1000};
	const int buffer = 4 << 20;
	const struct sockaddr_in own = {
		.sin_family = AF_INET,
		.sin_port = htons((uint16_t)from),
		.sin_addr.s_addr = htonl(INADDR_LOOPBACK),
	};
	const struct sockaddr_in peer = {
		.sin_family = AF_INET,
		.sin_port = htons((uint16_t)to),
		.sin_addr.s_addr = htonl(INADDR_LOOPBACK),
	};
	const int sock = socket(AF_INET, SOCK_DGRAM, 0);

	if (sock < 0 || bind(sock, (const struct sockaddr *)&own, sizeof(own)) != 0 ||
	    connect(sock, (const struct sockaddr *)&peer, sizeof(peer)) != 0 ||
	    setsockopt(sock, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout)) != 0 ||
	    setsockopt(sock, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof(buffer)) != 0) {
		perror("bench_client");
		exit(EXIT_FAILURE);
	}
	return sock;
}

int main(int argc, char *argv[])
{
	struct client self = {0};
	const bool rate = argc > 1 && strcmp(argv[1], "rate") == 0;

	if ((argc != 8 && argc != 10) || (!rate && strcmp(argv[1], "latency") != 0)) {
		(void)fprintf(stderr, "bench_client: latency|rate FROM TO ANSWER COUNT FRAME "
		                      "WINDOW [KEY TIMESTAMP]\n");
		return 2;
	}
	const unsigned long count = strtoul(argv[5], NULL, 10);
	const unsigned long window = strtoul(argv[7], NULL, 10);

	if (count < 1 || count > COUNT_MAX || window < 1 || window > WINDOW_MAX) {
		(void)fprintf(stderr, "bench_client: COUNT 1…%d, WINDOW 1…%d\n", COUNT_MAX,
		              WINDOW_MAX);
		return 2;
	}
	self.sock = connect_from_to(strtoul(argv[2], NULL, 10), strtoul(argv[3], NULL, 10));
	self.answer_id = (uint32_t)strtoul(argv[4], NULL, 10);
	self.frame_length = parse_hex(argv[6], self.frame, sizeof(self.frame));
	if (argc == 10) {
		/* Those of the warm-up too, and some for those that are sent anew. */
		sign_frames(&self, count + count / 2 + WINDOW_MAX, argv[8],
		            strtoull(argv[9], NULL, 10));
	}
	return rate ? measure_rate(&self, count, (unsigned int)window)
	            : measure_latency(&self, count);
}
