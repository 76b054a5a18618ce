/* SPDX-License-Identifier: Apache-2.0 */
/**
 * @file
 * What every harness has: an entry for libFuzzer, and a check that ends it where it does not hold.
 */
#ifndef PHAROS_FUZZ_CHECK_H_
#define PHAROS_FUZZ_CHECK_H_

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* One execution. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define CHECK(condition)                                                                           \
	do {                                                                                       \
		if (!(condition)) {                                                                \
			fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);            \
			abort();                                                                   \
		}                                                                                  \
	} while (0)

#endif /* PHAROS_FUZZ_CHECK_H_ */
