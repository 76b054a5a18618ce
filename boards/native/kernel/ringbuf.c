/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include <zephyr/sys/ring_buffer.h>

void ring_buf_init(struct ring_buf *buf, uint32_t size, uint8_t *data)
{
	*buf = (struct ring_buf)RING_BUF_INIT(data, size);
}

bool ring_buf_is_empty(struct ring_buf *buf)
{
	return ring_buf_size_get(buf) == 0;
}

uint32_t ring_buf_space_get(struct ring_buf *buf)
{
	return (uint32_t)(buf->size - (buf->put_claimed - buf->get_done));
}

uint32_t ring_buf_size_get(struct ring_buf *buf)
{
	return (uint32_t)(buf->put_done - buf->get_claimed);
}

static uint32_t contiguous(const struct ring_buf *buf, uint64_t from, uint32_t available,
                           uint32_t wanted)
{
	const uint32_t to_end = buf->size - (uint32_t)(from % buf->size);

	return MIN(MIN(available, wanted), to_end);
}

uint32_t ring_buf_put_claim(struct ring_buf *buf, uint8_t **data, uint32_t size)
{
	const uint32_t claimed = contiguous(buf, buf->put_claimed, ring_buf_space_get(buf), size);

	*data = &buf->buffer[buf->put_claimed % buf->size];
	buf->put_claimed += claimed;
	return claimed;
}

int ring_buf_put_finish(struct ring_buf *buf, uint32_t size)
{
	if (size > buf->put_claimed - buf->put_done) {
		return -EINVAL;
	}
	buf->put_done += size;
	buf->put_claimed = buf->put_done;
	return 0;
}

uint32_t ring_buf_put(struct ring_buf *buf, const uint8_t *data, uint32_t size)
{
	uint32_t done = 0;
	uint32_t claimed;

	do {
		uint8_t *dst;

		claimed = ring_buf_put_claim(buf, &dst, size - done);
		memcpy(dst, data + done, claimed);
		done += claimed;
	} while (claimed > 0 && done < size);
	(void)ring_buf_put_finish(buf, done);
	return done;
}

uint32_t ring_buf_get_claim(struct ring_buf *buf, uint8_t **data, uint32_t size)
{
	const uint32_t claimed = contiguous(buf, buf->get_claimed, ring_buf_size_get(buf), size);

	*data = &buf->buffer[buf->get_claimed % buf->size];
	buf->get_claimed += claimed;
	return claimed;
}

int ring_buf_get_finish(struct ring_buf *buf, uint32_t size)
{
	if (size > buf->get_claimed - buf->get_done) {
		return -EINVAL;
	}
	buf->get_done += size;
	buf->get_claimed = buf->get_done;
	return 0;
}

uint32_t ring_buf_get(struct ring_buf *buf, uint8_t *data, uint32_t size)
{
	uint32_t done = 0;
	uint32_t claimed;

	do {
		uint8_t *src;

		claimed = ring_buf_get_claim(buf, &src, size - done);
		if (data != NULL) {
			memcpy(data + done, src, claimed);
		}
		done += claimed;
	} while (claimed > 0 && done < size);
	(void)ring_buf_get_finish(buf, done);
	return done;
}
