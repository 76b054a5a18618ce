/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a UART speaks, as its thread sees it: received bytes become packets, which go to the inbox.
 * A protocol is a table; which one a UART has is decided at the start.
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

/* Valid until more is written. */
union uart_packet {
	struct mavlink_frame mavlink;
#ifdef CONFIG_PHAROS_IMC
	struct imc_stream_packet imc;
#endif
};

/*
 * write: as many bytes as have room, which it returns; then next: the packets that there are now.
 * idle: the line is silent, so that an unfinished packet was perhaps none and hides a good one; go
 * on with next. post: to the inbox, as of the link; waits while the command thread is behind.
 * pending: there is an unfinished one. wanted: bytes that must come before there can be another.
 */
struct uart_framing {
	void (*init)(union uart_framing_state *state);
	size_t (*write)(union uart_framing_state *state, const uint8_t *bytes, size_t count);
	bool (*next)(union uart_framing_state *state, union uart_packet *packet);
	bool (*idle)(union uart_framing_state *state, union uart_packet *packet);
	void (*post)(uint8_t link, const union uart_packet *packet);
	bool (*pending)(const union uart_framing_state *state);
	size_t (*wanted)(const union uart_framing_state *state);
	struct link_framing_stats (*stats)(const union uart_framing_state *state); /* any thread */
};

extern const struct uart_framing uart_framing_mavlink;
extern const struct uart_framing uart_framing_imc; /* with CONFIG_PHAROS_IMC */

#endif
