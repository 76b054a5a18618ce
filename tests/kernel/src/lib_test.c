/* SPDX-License-Identifier: Apache-2.0 */
/* Data structures and helpers. */
#include <zephyr/sys/byteorder.h>
#include <zephyr/sys/ring_buffer.h>

#include "helper.h"

ZTEST(kernel_lib, test_ring_buffer_wraps)
{
	uint8_t storage[5], out[5], *place;
	struct ring_buf ring;

	ring_buf_init(&ring, sizeof(storage), storage);
	zassert_equal(ring_buf_put(&ring, (const uint8_t *)"abcdefg", 7), 5);
	zassert_equal(ring_buf_get(&ring, out, 3), 3);
	zassert_mem_equal(out, "abc", 3);
	zassert_equal(ring_buf_put(&ring, (const uint8_t *)"xyz", 3), 3);
	zassert_equal(ring_buf_space_get(&ring), 0);
	zassert_equal(ring_buf_get_claim(&ring, &place, 5), 2, "up to the end of the storage");
	zassert_mem_equal(place, "de", 2);
	zassert_equal(ring_buf_get_finish(&ring, 3), -EINVAL);
	zassert_equal(ring_buf_get_finish(&ring, 1), 0);
	zassert_equal(ring_buf_get(&ring, out, 5), 4);
	zassert_mem_equal(out, "exyz", 4);
	zassert_true(ring_buf_is_empty(&ring));
}

ZTEST(kernel_lib, test_slist)
{
	sys_snode_t a, b, c;
	sys_slist_t list;

	sys_slist_init(&list);
	sys_slist_append(&list, &b);
	sys_slist_prepend(&list, &a);
	sys_slist_insert(&list, &b, &c);
	zassert_equal_ptr(sys_slist_peek_tail(&list), &c);
	zassert_true(sys_slist_find_and_remove(&list, &c));
	zassert_false(sys_slist_find_and_remove(&list, &c));
	zassert_equal_ptr(sys_slist_peek_tail(&list), &b);
	zassert_equal_ptr(sys_slist_get(&list), &a);
	zassert_equal_ptr(sys_slist_get(&list), &b);
	zassert_is_null(sys_slist_get(&list));
}

ZTEST(kernel_lib, test_atomic_bits)
{
	ATOMIC_DEFINE(bits, 100) = {0};
	atomic_t value = ATOMIC_INIT(5);

	zassert_false(atomic_test_and_set_bit(bits, 99));
	zassert_true(atomic_test_bit(bits, 99));
	zassert_true(atomic_test_and_clear_bit(bits, 99));
	zassert_false(atomic_test_bit(bits, 99));
	zassert_equal(atomic_add(&value, 3), 5);
	zassert_true(atomic_cas(&value, 8, 1));
	zassert_false(atomic_cas(&value, 8, 2));
	zassert_equal(atomic_get(&value), 1);
}

ZTEST(kernel_lib, test_byte_order)
{
	uint8_t bytes[8];

	sys_put_be32(0x01020304, bytes);
	zassert_mem_equal(bytes, "\x01\x02\x03\x04", 4);
	zassert_equal(sys_get_le32(bytes), 0x04030201);
	sys_put_le16(0x0102, bytes);
	zassert_mem_equal(bytes, "\x02\x01", 2);
	sys_put_le64(0x0102030405060708ULL, bytes);
	zassert_equal(sys_get_be64(bytes), 0x0807060504030201ULL);
	zassert_equal(sys_get_be24(bytes), 0x080706);
}

#define PLUS(x)        +(x)
#define WEIGHTED(i, x) (i) * (x)
#define ON             1

ZTEST(kernel_lib, test_macros)
{
	zassert_equal(0 FOR_EACH(PLUS, (), 1, 2, 3, 4), 10);
	zassert_equal(FOR_EACH_IDX(WEIGHTED, (+), 5, 6, 7), 20);
	zassert_equal(COND_CODE_1(ON, (11), (22)), 11);
	zassert_equal(COND_CODE_1(OFF, (11), (22)), 22);
	zassert_equal(COND_CODE_0(ON, (11), (22)), 22);
	zassert_equal(IS_ENABLED(ON), 1);
	zassert_equal(IS_ENABLED(OFF), 0);
	zassert_equal(GENMASK(7, 4), 0xf0);
	zassert_equal(FIELD_GET(GENMASK(7, 4), 0xabc), 0xb);
	zassert_equal(ROUND_UP(13, 8), 16);
	zassert_equal(DIV_ROUND_UP(13, 8), 2);
}

ZTEST_SUITE(kernel_lib, NULL, NULL, NULL, NULL, NULL);
