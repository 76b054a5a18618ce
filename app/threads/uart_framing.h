/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a UART speaks, as its thread sees it: received bytes become frames in the inbox. A protocol
 * is a table; which one a UART has is decided at the start.
 *
 * Context: the UART's thread.
 */
#ifndef PHAROS_THREADS_UART_FRAMING_H
#define PHAROS_THREADS_UART_FRAMING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/mavlink/framer.h"
#include "threads/link.h"

#ifdef CONFIG_PHAROS_IMC
#include "proto/imc/stream.h"
#endif

union uart_framing_state {
	struct mavlink_framer mavlink;
#ifdef CONFIG_PHAROS_IMC
	struct imc_stream imc;
#endif
};

/*
 * take: all the bytes; idle: the line is silent, so that an unfinished frame was perhaps none and
 * hides good ones. Both return how many frames they have posted, as of the link. pending: there is
 * an unfinished one. wanted: bytes that must come before there can be another.
 */
struct uart_framing {
	void (*init)(union uart_framing_state *state);
	uint32_t (*take)(union uart_framing_state *state, uint8_t link, const uint8_t *bytes,
	                 size_t count);
	uint32_t (*idle)(union uart_framing_state *state, uint8_t link);
	bool (*pending)(const union uart_framing_state *state);
	size_t (*wanted)(const union uart_framing_state *state);
	struct link_framing_stats (*stats)(const union uart_framing_state *state); /* any thread */
};

extern const struct uart_framing uart_framing_mavlink;
extern const struct uart_framing uart_framing_imc; /* with CONFIG_PHAROS_IMC */

#endif
