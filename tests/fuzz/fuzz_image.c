/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libFuzzer: firmware images.
 *
 * Input: a byte that says how large the pieces are, a byte of options (bit 0: make the header one
 * of MCUboot's, or little would get past it), then the file. Invariants: nothing is read out of
 * bounds (sanitizers), no assertion; the result does not depend on the pieces; a whole image fits
 * its slot, and its hash covers no more than came.
 */
#include "core/image.h"

#include "check.h"

#include <string.h>

#define SLOT     4096u
#define FILE_MAX 8192u

static enum image_result check(struct image *image, const uint8_t *data, size_t size, size_t piece)
{
	image_init(image, SLOT);
	for (size_t at = 0; at < size; at += piece) {
		(void)image_write(image, data + at, size - at < piece ? size - at : piece);
	}
	return image_finish(image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static const uint8_t magic[] = {0x3D, 0xB8, 0xF3, 0x96};
	static uint8_t file[FILE_MAX];
	static struct image image;
	static struct image whole;

	if (size < 2 || size - 2 > sizeof(file)) {
		return 0;
	}
	const size_t piece = 1u + data[0];
	const uint8_t options = data[1];

	size -= 2;
	memcpy(file, data + 2, size);
	if ((options & 1u) != 0 && size >= IMAGE_HEADER_SIZE) {
		memcpy(file, magic, sizeof(magic));
		file[8] |= IMAGE_HEADER_SIZE;
		file[9] = 0;   /* header size, high byte */
		file[11] = 0;  /* of the protected area */
		file[13] &= 1; /* of the code */
		file[14] = file[15] = 0;
	}
	const enum image_result result = check(&image, file, size, piece);

	CHECK(result == check(&whole, file, size, FILE_MAX));
	CHECK(image.offset == whole.offset || result != IMAGE_OK);
	if (result == IMAGE_OK) {
		CHECK(image.offset == size && size <= SLOT);
		CHECK(image.hashed_size < size && image.has_hash);
		CHECK(memcmp(image.hash, whole.hash, IMAGE_HASH_SIZE) == 0);
	}
	return 0;
}
