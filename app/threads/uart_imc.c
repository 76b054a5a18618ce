/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/outbox.h"
#include "threads/inbox.h"
#include "threads/uart_framing.h"

_Static_assert(MAVLINK_FRAMER_IDLE_US == IMC_STREAM_IDLE_US, "one wait does for both");

static void init(union uart_framing_state *state)
{
	imc_stream_init(&state->imc);
}

static size_t write(union uart_framing_state *state, const uint8_t *bytes, size_t count)
{
	return imc_stream_write(&state->imc, bytes, count);
}

static bool next(union uart_framing_state *state, union uart_packet *packet)
{
	return imc_stream_next(&state->imc, &packet->imc);
}

static bool idle(union uart_framing_state *state, union uart_packet *packet)
{
	return imc_stream_idle(&state->imc, &packet->imc);
}

static void post(uint8_t link, const union uart_packet *packet)
{
	const struct imc_route route = {.link = link};

	inbox_post_imc(&route, packet->imc.bytes, packet->imc.length, SUPERVISOR_UART_LINK0 + link);
}

static bool pending(const union uart_framing_state *state)
{
	return imc_stream_pending(&state->imc);
}

static size_t wanted(const union uart_framing_state *state)
{
	return imc_stream_wanted(&state->imc);
}

static struct link_framing_stats stats(const union uart_framing_state *state)
{
	return (struct link_framing_stats){
		.crc_errors = state->imc.stats.checksum_errors,
		.resyncs = state->imc.stats.resyncs,
		.skipped_bytes = state->imc.stats.skipped_bytes,
	};
}

const struct uart_framing uart_framing_imc = {
	.init = init,
	.write = write,
	.next = next,
	.idle = idle,
	.post = post,
	.pending = pending,
	.wanted = wanted,
	.stats = stats,
};
