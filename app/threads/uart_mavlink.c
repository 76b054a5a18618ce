/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/inbox.h"
#include "threads/uart_framing.h"

static void init(union uart_framing_state *state)
{
	mavlink_framer_init(&state->mavlink);
}

/* To the command thread, which takes it before this one goes on; waits while it is behind. */
static void post(uint8_t link, const struct mavlink_frame *frame)
{
	inbox_post_frame(link, frame->bytes, frame->length, SUPERVISOR_UART_LINK0 + link);
}

static uint32_t post_all(struct mavlink_framer *framer, uint8_t link)
{
	struct mavlink_frame frame;
	uint32_t posted = 0;

	while (mavlink_framer_next(framer, &frame)) {
		post(link, &frame);
		posted++;
	}
	return posted;
}

static uint32_t take(union uart_framing_state *state, uint8_t link, const uint8_t *bytes,
                     size_t count)
{
	uint32_t posted = 0;

	state->mavlink.opaque = link_is_opaque();
	for (size_t used = 0; used < count;) {
		used += mavlink_framer_write(&state->mavlink, bytes + used, count - used);
		posted += post_all(&state->mavlink, link);
	}
	return posted;
}

static uint32_t idle(union uart_framing_state *state, uint8_t link)
{
	struct mavlink_frame frame;
	uint32_t posted = 0;

	while (mavlink_framer_idle(&state->mavlink, &frame)) {
		post(link, &frame);
		posted += 1 + post_all(&state->mavlink, link);
	}
	return posted;
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
	.take = take,
	.idle = idle,
	.pending = pending,
	.wanted = wanted,
	.stats = stats,
};
