/* SPDX-License-Identifier: Apache-2.0 */
/* Who is heard while there is a key, and how a key comes and goes. */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

_Static_assert(sizeof(((mavlink_setup_signing_t *)0)->secret_key) == MAVLINK_SIGNING_KEY_BYTES,
               "common.xml");

void mavlink_endpoint_restore_key(struct mavlink_endpoint *self, int64_t now_us,
                                  const struct mavlink_signing_record *stored)
{
	mavlink_signing_init(&self->signing, now_us, stored);
}

void mavlink_endpoint_set_key(struct mavlink_endpoint *self, int64_t now_us,
                              const struct mavlink_signing_record *record)
{
	const bool was_on = self->signing.on;

	mavlink_signing_set_key(&self->signing, now_us, record);
	if (self->signing.on || was_on) {
		(void)mavlink_endpoint_text(self, now_us, MAV_SEVERITY_NOTICE,
		                            self->signing.on ? "MAVLink signing: a key is set"
		                                             : "MAVLink signing: off");
	}
}

/* Only on a secure link, only to us, and rightly signed if there is a key already. */
static bool setup_is_allowed(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                             const struct mavlink_frame *frame,
                             const mavlink_setup_signing_t *setup)
{
	return (self->config.secure_links & 1u << link) != 0 &&
	       mavlink_is_ours(self, setup->target_system, setup->target_component) &&
	       mavlink_signing_check(&self->signing, now_us, frame) == MAVLINK_SIGNING_ACCEPTED;
}

static void take_setup(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                       const struct mavlink_frame *frame)
{
	struct mavlink_signing_record record;
	mavlink_setup_signing_t setup;

	mavlink_frame_payload(frame, &setup, sizeof(setup));
	if (!setup_is_allowed(self, now_us, link, frame, &setup)) {
		self->signing.stats.setups_refused++;
		return;
	}
	self->signing.stats.setups++;
	record.timestamp = setup.initial_timestamp;
	memcpy(record.key, setup.secret_key, sizeof(record.key));
	mavlink_endpoint_set_key(self, now_us, &record);
}

bool mavlink_admit(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                   const struct mavlink_frame *frame)
{
	if (frame->message_id == MAVLINK_MSG_ID_SETUP_SIGNING) {
		take_setup(self, now_us, link, frame);
		return false;
	}
	return mavlink_signing_check(&self->signing, now_us, frame) == MAVLINK_SIGNING_ACCEPTED;
}

bool mavlink_is_signing(const struct mavlink_endpoint *self)
{
	return self->signing.on;
}

size_t mavlink_sign(struct mavlink_endpoint *self, int64_t now_us, uint8_t link, uint8_t *bytes,
                    size_t length)
{
	return mavlink_signing_sign(&self->signing, now_us, bytes, length, link);
}

void mavlink_signing_step(struct mavlink_endpoint *self, int64_t now_us, struct mavlink_outbox *out)
{
	if (mavlink_signing_deadline_us(&self->signing) <= now_us) {
		out->signing = mavlink_signing_take_record(&self->signing, now_us);
		out->store_signing = true;
	}
}

int64_t mavlink_signing_due_us(const struct mavlink_endpoint *self)
{
	return mavlink_signing_deadline_us(&self->signing);
}
