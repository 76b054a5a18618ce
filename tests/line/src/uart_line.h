/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The far end of the modelled line. What it sends comes to the light byte after byte at the line's
 * rate, whatever the light does; what the light sends is kept.
 */
#ifndef PHAROS_TESTS_LINE_UART_LINE_H
#define PHAROS_TESTS_LINE_UART_LINE_H

#include <stddef.h>
#include <stdint.h>

struct uart_line_result {
	size_t sent;       /* of the bytes for the light */
	size_t received;   /* from the light */
	uint32_t overruns; /* bytes that came while the FIFO was full */
	uint32_t most;     /* bytes in the FIFO at once */
};

/*
 * From now on count bytes go to the light, and up to room bytes from it are kept. Both must stay
 * until uart_line_stop().
 */
void uart_line_start(const uint8_t *bytes, size_t count, uint8_t *kept, size_t room);

/* Anything from uart_line_start() to now. */
struct uart_line_result uart_line_stop(void);

#endif
