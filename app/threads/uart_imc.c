/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/outbox.h"
#include "threads/inbox.h"
#include "threads/uart_framing.h"

_Static_assert(MAVLINK_FRAMER_IDLE_US == IMC_STREAM_IDLE_US, "one wait does for both");

static void init(union uart_framing_state *state)
{
	imc_stream_init(&state->imc);
}

static void post(uint8_t link, const struct imc_stream_packet *packet)
{
	const struct imc_route route = {.link = link};

	inbox_post_imc(&route, packet->bytes, packet->length, SUPERVISOR_UART_LINK0 + link);
}

static uint32_t post_all(struct imc_stream *stream, uint8_t link)
{
	struct imc_stream_packet packet;
	uint32_t posted = 0;

	while (imc_stream_next(stream, &packet)) {
		post(link, &packet);
		posted++;
	}
	return posted;
}

static uint32_t take(union uart_framing_state *state, uint8_t link, const uint8_t *bytes,
                     size_t count)
{
	uint32_t posted = 0;

	for (size_t used = 0; used < count;) {
		used += imc_stream_write(&state->imc, bytes + used, count - used);
		posted += post_all(&state->imc, link);
	}
	return posted;
}

static uint32_t idle(union uart_framing_state *state, uint8_t link)
{
	struct imc_stream_packet packet;
	uint32_t posted = 0;

	while (imc_stream_idle(&state->imc, &packet)) {
		post(link, &packet);
		posted += 1 + post_all(&state->imc, link);
	}
	return posted;
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
	.take = take,
	.idle = idle,
	.pending = pending,
	.wanted = wanted,
	.stats = stats,
};
