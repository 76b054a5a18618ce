/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/inbox.h"
#include "threads/uart_framing.h"

static void init(union uart_framing_state *state)
{
	mavlink_framer_init(&state->mavlink);
}

static size_t write(union uart_framing_state *state, const uint8_t *bytes, size_t count)
{
	state->mavlink.opaque = link_is_opaque();
	return mavlink_framer_write(&state->mavlink, bytes, count);
}

static bool next(union uart_framing_state *state, union uart_packet *packet)
{
	return mavlink_framer_next(&state->mavlink, &packet->mavlink);
}

static bool idle(union uart_framing_state *state, union uart_packet *packet)
{
	return mavlink_framer_idle(&state->mavlink, &packet->mavlink);
}

static void post(uint8_t link, const union uart_packet *packet)
{
	inbox_post_frame(link, packet->mavlink.bytes, packet->mavlink.length,
	                 SUPERVISOR_UART_LINK0 + link);
}

static bool pending(const union uart_framing_state *state)
{
	return mavlink_framer_pending(&state->mavlink);
}

static size_t wanted(const union uart_framing_state *state)
{
	return mavlink_framer_wanted(&state->mavlink);
}

static struct link_framing_stats stats(const union uart_framing_state *state)
{
	return link_framing_of(&state->mavlink.stats);
}

const struct uart_framing uart_framing_mavlink = {
	.init = init,
	.write = write,
	.next = next,
	.idle = idle,
	.post = post,
	.pending = pending,
	.wanted = wanted,
	.stats = stats,
};
