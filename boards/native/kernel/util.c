/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>

#include <zephyr/sys/util.h>

int char2hex(char c, uint8_t *x)
{
	if (c >= '0' && c <= '9') {
		*x = (uint8_t)(c - '0');
	} else if (c >= 'a' && c <= 'f') {
		*x = (uint8_t)(c - 'a' + 10);
	} else if (c >= 'A' && c <= 'F') {
		*x = (uint8_t)(c - 'A' + 10);
	} else {
		return -EINVAL;
	}
	return 0;
}

/* An odd number of digits: the first byte has one digit only. */
size_t hex2bin(const char *hex, size_t hexlen, uint8_t *buf, size_t buflen)
{
	const size_t odd = hexlen % 2;
	const size_t bytes = hexlen / 2 + odd;

	if (buflen < bytes) {
		return 0;
	}
	for (size_t i = 0; i < bytes; i++) {
		uint8_t high = 0, low;

		if ((i > 0 || odd == 0) && char2hex(hex[2 * i - odd], &high) != 0) {
			return 0;
		}
		if (char2hex(hex[2 * i + 1 - odd], &low) != 0) {
			return 0;
		}
		buf[i] = (uint8_t)(high << 4 | low);
	}
	return bytes;
}
