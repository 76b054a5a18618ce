/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Byte ring buffer. One producer and one consumer need no lock. All bytes of the buffer are usable.
 * Sizes in bytes, below 2^31.
 */
#ifndef ZEPHYR_SYS_RING_BUFFER_H_
#define ZEPHYR_SYS_RING_BUFFER_H_

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/sys/util.h>

struct ring_buf {
	uint8_t *buffer;
	uint32_t size;
	/* Byte counts since the start: claimed and finished, by the producer and by the consumer.
	 */
	uint64_t put_claimed, put_done;
	uint64_t get_claimed, get_done;
};

#define RING_BUFFER_MAX_SIZE 0x80000000U

#define RING_BUF_INIT(buf, size8)                                                                  \
	{                                                                                          \
		.buffer = (buf), .size = (size8)                                                   \
	}

#define RING_BUF_DECLARE(name, size8)                                                              \
	BUILD_ASSERT((size8) < RING_BUFFER_MAX_SIZE, "too large");                                 \
	static uint8_t _ring_buffer_data_##name[size8];                                            \
	struct ring_buf name = RING_BUF_INIT(_ring_buffer_data_##name, size8)

void ring_buf_init(struct ring_buf *buf, uint32_t size, uint8_t *data);
bool ring_buf_is_empty(struct ring_buf *buf);
uint32_t ring_buf_space_get(struct ring_buf *buf);
uint32_t ring_buf_size_get(struct ring_buf *buf);

/* Contiguous room for at most size bytes; finish with the number written, or -EINVAL: more than
 * claimed. */
uint32_t ring_buf_put_claim(struct ring_buf *buf, uint8_t **data, uint32_t size);
int ring_buf_put_finish(struct ring_buf *buf, uint32_t size);
/* Returns how many bytes fitted. */
uint32_t ring_buf_put(struct ring_buf *buf, const uint8_t *data, uint32_t size);

uint32_t ring_buf_get_claim(struct ring_buf *buf, uint8_t **data, uint32_t size);
int ring_buf_get_finish(struct ring_buf *buf, uint32_t size);
/* data == NULL: drops. Returns how many bytes there were. */
uint32_t ring_buf_get(struct ring_buf *buf, uint8_t *data, uint32_t size);

#endif
