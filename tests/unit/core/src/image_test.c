/* SPDX-License-Identifier: Apache-2.0 */
#include "core/image.h"

#include "vectors/images.h"

#include <string.h>

#include <zephyr/ztest.h>

#define SLOT 4096

static struct image image;
static uint8_t bytes[256];

ZTEST_SUITE(core_image, NULL, NULL, NULL, NULL, NULL);

/* In pieces of that size. */
static enum image_result check(const uint8_t *data, size_t size, size_t piece)
{
	image_init(&image, SLOT);
	for (size_t done = 0; done < size; done += piece) {
		(void)image_write(&image, data + done, MIN(piece, size - done));
	}
	return image_finish(&image);
}

ZTEST(core_image, test_images_of_imgtool_are_whole_whatever_the_pieces)
{
	for (size_t piece = 1; piece <= sizeof(image_protected); piece++) {
		zassert_equal(check(image_plain, sizeof(image_plain), piece), IMAGE_OK);
		zassert_equal(image.hashed_size, 32 + 40);
		zassert_mem_equal(image.hash, image_plain + 32 + 40 + 4 + 4, IMAGE_HASH_SIZE);

		zassert_equal(check(image_protected, sizeof(image_protected), piece), IMAGE_OK);
		zassert_equal(image.hashed_size, 32 + 40 + 12);
		zassert_mem_equal(image.hash, image_protected + 32 + 40 + 12 + 4 + 4,
		                  IMAGE_HASH_SIZE);
	}
	zassert_equal(image.version.major, 1);
	zassert_equal(image.version.minor, 2);
	zassert_equal(image.version.revision, 3);
	zassert_equal(image.version.build, 4);
}

ZTEST(core_image, test_each_shorter_one_is_incomplete)
{
	for (size_t size = 0; size < sizeof(image_protected); size++) {
		zassert_equal(check(image_protected, size, size + 1), IMAGE_INCOMPLETE, "%zu",
		              size);
	}
}

ZTEST(core_image, test_a_byte_more_is_refused_and_stays_so)
{
	memcpy(bytes, image_plain, sizeof(image_plain));
	zassert_equal(check(bytes, sizeof(image_plain) + 1, 7), IMAGE_TRAILING_DATA);
	zassert_equal(image_write(&image, bytes, 1), IMAGE_TRAILING_DATA);
}

static enum image_result changed(size_t at, uint8_t value)
{
	memcpy(bytes, image_protected, sizeof(image_protected));
	bytes[at] = value;
	return check(bytes, sizeof(image_protected), sizeof(bytes));
}

/* Offsets: MCUboot's struct image_header, struct image_tlv_info, struct image_tlv. */
ZTEST(core_image, test_what_is_not_mcuboots_is_refused)
{
	zassert_equal(changed(0, 0), IMAGE_NOT_AN_IMAGE);     /* magic */
	zassert_equal(changed(8, 31), IMAGE_NOT_AN_IMAGE);    /* header shorter than a header */
	zassert_equal(changed(12, 0), IMAGE_NOT_AN_IMAGE);    /* no code */
	zassert_equal(changed(15, 0x80), IMAGE_TOO_LARGE);    /* 2 GiB of code */
	zassert_equal(changed(13, 0x10), IMAGE_TOO_LARGE);    /* 4 KiB of code in a slot of 4 KiB */
	zassert_equal(changed(72, 0x07), IMAGE_BAD_TRAILER);  /* not the protected area's magic */
	zassert_equal(changed(74, 13), IMAGE_BAD_TRAILER);    /* longer than the header says */
	zassert_equal(changed(78, 5), IMAGE_BAD_TRAILER);     /* an entry longer than its area */
	zassert_equal(changed(84, 0x08), IMAGE_BAD_TRAILER);  /* the area after it: its magic */
	zassert_equal(changed(86, 3), IMAGE_BAD_TRAILER);     /* an area shorter than its head */
	zassert_equal(changed(87, 0xFF), IMAGE_TOO_LARGE);    /* an area beyond the slot */
	zassert_equal(changed(90, 31), IMAGE_BAD_TRAILER);    /* a SHA-256 of 31 bytes */
	zassert_equal(changed(88, 0x11), IMAGE_WITHOUT_HASH); /* another kind of entry */
}

ZTEST(core_image, test_a_wrong_file_is_refused_with_its_header)
{
	image_init(&image, SLOT);
	memset(bytes, 0, sizeof(bytes));
	zassert_equal(image_write(&image, bytes, IMAGE_HEADER_SIZE - 1), IMAGE_OK);
	zassert_equal(image_write(&image, bytes, 1), IMAGE_NOT_AN_IMAGE);
	zassert_equal(strcmp(image_result_text(image.result), "not an image of MCUboot's"), 0);
}

/* The whole image, its trailer included, fits to the byte. */
ZTEST(core_image, test_the_slots_size_is_exact)
{
	image_init(&image, sizeof(image_protected));
	(void)image_write(&image, image_protected, sizeof(image_protected));
	zassert_equal(image_finish(&image), IMAGE_OK);
	image_init(&image, sizeof(image_protected) - 1);
	zassert_equal(image_write(&image, image_protected, sizeof(image_protected)),
	              IMAGE_TOO_LARGE);
}
