/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

_Static_assert(sizeof(((mavlink_statustext_t *)0)->text) == MAVLINK_TEXT_BYTES, "common.xml");

void mavlink_texts_init(struct mavlink_texts *self)
{
	memset(self, 0, sizeof(*self));
	self->credit = MAVLINK_TEXT_BURST;
}

/* A credit per period, up to a burst. */
static void gain_credit(struct mavlink_texts *self, int64_t now_us)
{
	if (self->credit == MAVLINK_TEXT_BURST) {
		self->credited_us = now_us;
		return;
	}

	const int64_t gained = (now_us - self->credited_us) / MAVLINK_TEXT_PERIOD_US;

	if (gained >= MAVLINK_TEXT_BURST - self->credit) {
		self->credit = MAVLINK_TEXT_BURST;
		self->credited_us = now_us;
	} else if (gained > 0) {
		self->credit = (uint8_t)(self->credit + gained);
		self->credited_us += gained * MAVLINK_TEXT_PERIOD_US;
	}
}

bool mavlink_endpoint_text(struct mavlink_endpoint *self, int64_t now_us, uint8_t severity,
                           const char *text)
{
	struct mavlink_texts *const texts = &self->texts;

	gain_credit(texts, now_us);
	if (texts->credit == 0 || texts->count == MAVLINK_TEXTS_MAX) {
		texts->dropped++;
		return false;
	}
	texts->credit--;

	struct mavlink_text *const waiting =
		&texts->waiting[(texts->first + texts->count++) % MAVLINK_TEXTS_MAX];

	memset(waiting, 0, sizeof(*waiting));
	waiting->severity = severity;
	waiting->links = self->config.links;
	for (size_t i = 0; i < MAVLINK_TEXT_BYTES && text[i] != '\0'; i++) {
		waiting->text[i] = text[i];
	}
	if (now_us < self->due_us) {
		self->due_us = now_us;
	}
	return true;
}

static bool send_on_links(const struct mavlink_context *context, struct mavlink_text *waiting)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(STATUSTEXT);
	mavlink_statustext_t wire;

	memset(&wire, 0, sizeof(wire));
	wire.severity = waiting->severity;
	memcpy(wire.text, waiting->text, sizeof(wire.text));
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		if ((waiting->links & context->endpoint->config.links & 1u << link) == 0) {
			continue;
		}
		if (!mavlink_outbox_has_room(context->out)) {
			return false;
		}
		(void)mavlink_send(context, link, &kind, &wire);
		waiting->links &= (uint8_t) ~(1u << link);
	}
	return true;
}

bool mavlink_texts_step(struct mavlink_context *context)
{
	struct mavlink_texts *const texts = &context->endpoint->texts;

	if (context->endpoint->component_count == 0) {
		return true;
	}
	context->component = &context->endpoint->components[0];
	while (texts->count > 0) {
		if (!send_on_links(context, &texts->waiting[texts->first])) {
			return false;
		}
		texts->first = (uint8_t)((texts->first + 1) % MAVLINK_TEXTS_MAX);
		texts->count--;
	}
	return true;
}
