/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MAVLink endpoint: one system id, up to MAVLINK_COMPONENTS_MAX components, up to
 * MAVLINK_LINKS_MAX links. Sans-IO: frames and time in, an outbox out.
 *
 *   mavlink_illuminator_init(&service, &device, LAMP, &identity);
 *   mavlink_endpoint_init(&endpoint, &config);
 *   mavlink_endpoint_add(&endpoint, now_us, 243, &mavlink_illuminator_profile, &service);
 *   …
 *   mavlink_endpoint_receive(&endpoint, now_us, link, bytes, length, &out);
 *   perform the device's effects, mavlink_endpoint_tell(&endpoint, now_us, &effects), perform out
 *   while (mavlink_endpoint_deadline_us(&endpoint) <= now_us) {
 *           mavlink_endpoint_step(&endpoint, now_us, &out);                  the same
 *   }
 *
 * A component is described by a profile of constant tables: commands it carries out, messages it
 * can send (some of them streams), messages it takes. A new service is a new profile.
 *
 * Rules: a frame is for a component when its target is 0 or the component's, in both ids; what is
 * for others meets silence. An answer goes to the link and ids that the question came from.
 * Broadcasts go to every link. A command to all components is answered by those that know it, and
 * the message that it is about; the others are silent, since there are clients that take the first
 * acknowledgement for the vehicle's.
 *
 * Version: a link on which peers have only spoken version 1 is spoken to in version 1; the first
 * version 2 frame of a peer ends that, until the link goes down. Relays are no peers: what a modem
 * or a router says about itself (mavlink_is_relay, internal.h) decides nothing. What only version
 * 2 carries, and was asked for by name on that link, goes out in version 2 whatever the link's
 * version: a message requested, a stream whose interval was set. So the handshake of the guide
 * works: who asks for PROTOCOL_VERSION in version 1 is answered in version 2.
 *
 * With a key (signing.h), what is not rightly signed is not heard, and everything goes out signed,
 * in version 2. With routing (router.h), what others say to each other goes on to their links.
 * An answer is never more than a few frames, which always fit the outbox; streams that do not fit
 * leave the deadline in the past, so that the loop above sends them.
 *
 * Context: the thread that owns it. Spec: mavlink.io services command, ping, timesync; common.xml.
 */
#ifndef PHAROS_PROTO_MAVLINK_ENDPOINT_H
#define PHAROS_PROTO_MAVLINK_ENDPOINT_H

#include "proto/mavlink/frame.h"
#include "proto/mavlink/outbox.h"
#ifdef CONFIG_PHAROS_ROUTING
#include "proto/mavlink/router.h"
#endif
#include "proto/mavlink/signing.h"
#include "proto/mavlink/vehicle.h"

#include <stdbool.h>
#include <stdint.h>

#define MAVLINK_INTERVAL_OFF INT32_C(-1)

struct device_effects;
struct mavlink_endpoint;
struct mavlink_component;

/* What a function of a profile is told: who it works for, when, where the frame came from. */
struct mavlink_context {
	struct mavlink_endpoint *endpoint;
	struct mavlink_component *component;
	struct mavlink_outbox *out;
	int64_t now_us;
	uint8_t link;
	uint8_t source_system;
	uint8_t source_component;
	bool is_signed; /* rightly, with our key */
};

/* A command as it came. From COMMAND_INT: param[4], [5] are x and y as floats, param[6] is z. */
struct mavlink_command {
	float param[7];
	uint16_t id;
	bool to_all; /* to no component in particular */
};

union mavlink_payload {
	uint8_t bytes[MAVLINK_PAYLOAD_MAX];
	uint64_t align;
};

struct mavlink_message_row;

/* Beside the result: a message that goes out after the acknowledgement, when it is ACCEPTED. */
struct mavlink_reply {
	int32_t detail;                        /* COMMAND_ACK.result_param2, 0 when called */
	const struct mavlink_message_row *row; /* NULL: none */
	uint8_t links;                         /* bit per link */
	union mavlink_payload payload;
};

/* Instead of a result, of a command to all: what it asks for is somebody else's business. */
#define MAVLINK_NO_ANSWER 0xFFu

/*
 * run: carries the command out; returns a MAV_RESULT. reply->row is NULL when called.
 * cancel: of a command that takes time, else NULL. Its run returns IN_PROGRESS; the component's
 * step then calls mavlink_command_progress and, once, mavlink_command_done. cancel returns false
 * when it has come too late.
 * knows: whether the command is this component's, where an id means something else to others; NULL:
 * it always is.
 */
struct mavlink_command_row {
	uint16_t id;
	uint8_t (*run)(const struct mavlink_context *context, const struct mavlink_command *command,
	               struct mavlink_reply *reply);
	bool (*cancel)(const struct mavlink_context *context);
	bool (*knows)(const struct mavlink_command *command);
};

/*
 * interval_us: of the stream by default; MAVLINK_INTERVAL_OFF: only on request. Flags below.
 * fill: payload is zeroed, kind.length bytes in wire order. argument: of REQUEST_MESSAGE (param2),
 * NaN in a stream. Returns a MAV_RESULT; other than ACCEPTED: nothing is sent.
 */
struct mavlink_message_row {
	struct mavlink_kind kind;
	int32_t interval_us;
	uint8_t flags;
	uint8_t (*fill)(const struct mavlink_context *context, float argument, void *payload);
};
#define MAVLINK_MESSAGE_FIXED     0x01u /* its interval can't be changed */
#define MAVLINK_MESSAGE_ON_CHANGE 0x02u /* its stream also tells changes as they happen */

#define MAVLINK_NO_TARGET 0xFFu

/* Offsets of the target ids in the payload, MAVLINK_NO_TARGET: the message has none. */
struct mavlink_receiver_row {
	uint32_t id;
	uint8_t target_system_offset;
	uint8_t target_component_offset;
	void (*receive)(const struct mavlink_context *context, const struct mavlink_frame *frame);
};

struct mavlink_identity; /* identity.h */
struct mavlink_params;   /* param_service.h */

struct mavlink_profile {
	uint32_t capabilities; /* MAV_PROTOCOL_CAPABILITY beside those of every component */
	uint8_t type;          /* MAV_TYPE */
	uint8_t command_count;
	uint8_t message_count; /* at most MAVLINK_MESSAGES_MAX */
	uint8_t receiver_count;
	const struct mavlink_command_row *commands;
	const struct mavlink_message_row *messages;
	const struct mavlink_receiver_row *receivers;
	uint8_t (*system_status)(const void *service); /* MAV_STATE */
	/*
	 * What goes out by itself beside the streams (a list of parameters, a burst of a file, a
	 * command that takes time): sends what is due while the outbox has room. false: more is due
	 * than had room. deadline_us: when next, TIME_NEVER_US: nothing. Both or none.
	 */
	bool (*step)(const struct mavlink_context *context);
	int64_t (*deadline_us)(const void *service);
	const struct mavlink_identity *(*identity)(const void *service);
	/* What the component serves of the device's parameters; may be NULL. */
	struct mavlink_params *(*params)(void *service);
	/* The device has done something, on whoever's behalf; may be NULL. */
	void (*tell)(const struct mavlink_context *context, const struct device_effects *effects);
};

struct mavlink_stream {
	int64_t next_us;
	int32_t interval_us; /* MAVLINK_INTERVAL_OFF: silent */
	uint32_t sent_us;    /* the low bits of the last time */
};

/* The command that takes time and isn't done; id 0: none. Who waits for its result. */
struct mavlink_running {
	struct mavlink_command command;
	uint8_t percent;
	uint8_t link;
	uint8_t source_system;
	uint8_t source_component;
};

struct mavlink_component {
	const struct mavlink_profile *profile;
	void *service;
	struct mavlink_running running;
	uint8_t id;
	uint8_t sequence[MAVLINK_LINKS_MAX];
	uint16_t asked[MAVLINK_LINKS_MAX]; /* bit per stream whose interval a peer there has set */
	struct mavlink_stream streams[MAVLINK_LINKS_MAX][MAVLINK_MESSAGES_MAX];
};

struct mavlink_link_stats {
	uint32_t rx_frames;
	uint32_t rx_malformed;
	uint32_t rx_echoes; /* our own frames, come back */
	uint32_t rx_commands;
	uint32_t tx_frames;
};

struct mavlink_link {
	int64_t bulk_us; /* when bulk may go on */
	uint8_t version; /* 0: nothing heard yet, spoken to as 2 */
	struct mavlink_link_stats stats;
};

struct mavlink_text {
	char text[MAVLINK_TEXT_BYTES];
	uint8_t severity;
	uint8_t links; /* still to be sent on */
};

struct mavlink_texts {
	struct mavlink_text waiting[MAVLINK_TEXTS_MAX];
	int64_t credited_us;
	uint8_t first;
	uint8_t count;
	uint8_t credit;
	uint32_t dropped;
};

/*
 * system_id 1…255. adopt: until a vehicle's is adopted. links: bit per link that is up.
 * secure_links: those on which SETUP_SIGNING is obeyed. routing: whether what others say to each
 * other goes on. rates: bytes a second that a link carries.
 */
struct mavlink_endpoint_config {
	uint8_t system_id;
	bool adopt;
	uint8_t links;
	uint8_t secure_links;
	bool routing;
	uint32_t rates[MAVLINK_LINKS_MAX]; /* 0: MAVLINK_RATE_DEFAULT */
};

/* Readable by the owner; only the functions below write. */
struct mavlink_endpoint {
	struct mavlink_endpoint_config config;
	int64_t due_us;
	uint8_t component_count;
	struct mavlink_component components[MAVLINK_COMPONENTS_MAX];
	struct mavlink_link links[MAVLINK_LINKS_MAX];
	struct mavlink_texts texts;
	struct mavlink_vehicle vehicle;
#ifdef CONFIG_PHAROS_SIGNING
	struct mavlink_signing signing;
#endif
#ifdef CONFIG_PHAROS_ROUTING
	struct mavlink_router router;
#endif
};

/* config asserted. No component yet, so nothing is due. */
void mavlink_endpoint_init(struct mavlink_endpoint *self,
                           const struct mavlink_endpoint_config *config);

/*
 * Adds a component; its streams are due at once. id 1…255 and not there yet, profile and service
 * outlive the endpoint, at most MAVLINK_COMPONENTS_MAX: all asserted.
 */
void mavlink_endpoint_add(struct mavlink_endpoint *self, int64_t now_us, uint8_t id,
                          const struct mavlink_profile *profile, void *service);

/* Takes the vehicle's system id, 1…255 (asserted). */
void mavlink_endpoint_set_system_id(struct mavlink_endpoint *self, uint8_t system_id);

/* Change the config's last two. Left out of the build, they have no effect. */
void mavlink_endpoint_set_secure_links(struct mavlink_endpoint *self, uint8_t links);
void mavlink_endpoint_set_routing(struct mavlink_endpoint *self, bool on);

#ifdef CONFIG_PHAROS_SIGNING
/* The key and timestamp of the last run, before the first frame. */
void mavlink_endpoint_restore_key(struct mavlink_endpoint *self, int64_t now_us,
                                  const struct mavlink_signing_record *stored);

/* A key comes, or goes (all zero), from someone who is trusted. It is then to be stored. */
void mavlink_endpoint_set_key(struct mavlink_endpoint *self, int64_t now_us,
                              const struct mavlink_signing_record *record);
#endif

/*
 * A link comes: whoever is there now was not before, so its version is unknown and its streams are
 * the default ones, due at once. link < MAVLINK_LINKS_MAX (asserted).
 */
void mavlink_endpoint_link_up(struct mavlink_endpoint *self, int64_t now_us, uint8_t link);

/* A link goes: nothing is sent there any more. */
void mavlink_endpoint_link_down(struct mavlink_endpoint *self, uint8_t link);

/*
 * bytes: one whole frame that a framer has verified; link < MAVLINK_LINKS_MAX (asserted). *out is
 * overwritten. What is not one frame is counted and left.
 */
void mavlink_endpoint_receive(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                              const uint8_t *bytes, size_t length, struct mavlink_outbox *out);

/* Sends what is due, as much as fits. *out is overwritten. */
void mavlink_endpoint_step(struct mavlink_endpoint *self, int64_t now_us,
                           struct mavlink_outbox *out);

/* When step has something to send; TIME_NEVER_US: nothing. */
int64_t mavlink_endpoint_deadline_us(const struct mavlink_endpoint *self);

/* What the device did, on whoever's behalf, ours included: it becomes news, sent with the steps. */
void mavlink_endpoint_tell(struct mavlink_endpoint *self, int64_t now_us,
                           const struct device_effects *effects);

/*
 * Tells people on every link. severity: MAV_SEVERITY 0…7. text: cut after MAVLINK_TEXT_BYTES.
 * false: too many lately; dropped and counted. For one-off events; a caller that may repeat itself
 * limits its own rate as well.
 */
bool mavlink_endpoint_text(struct mavlink_endpoint *self, int64_t now_us, uint8_t severity,
                           const char *text);

/* --- for profiles ---------------------------------------------------------------------------- */

/*
 * Sends kind with payload from the context's component on one link. The outbox has room
 * (asserted). false: the link's version can't carry it.
 */
bool mavlink_send(const struct mavlink_context *context, uint8_t link,
                  const struct mavlink_kind *kind, const void *payload);

/* The same for what was asked for by name on that link: in version 2 where 1 can't carry it. */
void mavlink_send_asked(const struct mavlink_context *context, uint8_t link,
                        const struct mavlink_kind *kind, const void *payload);

/*
 * Bulk (a list of parameters, a file) shares MAVLINK_BULK_PERCENT of a link's rate, so that the
 * rest stays for commands and streams: nothing of it goes before mavlink_bulk_due_us. Sends as
 * mavlink_send does and moves that time on.
 */
int64_t mavlink_bulk_due_us(const struct mavlink_endpoint *self, uint8_t link);
bool mavlink_send_bulk(const struct mavlink_context *context, uint8_t link,
                       const struct mavlink_kind *kind, const void *payload);

/*
 * Of the context's component's command that takes time (asserted that there is one): how much is
 * done, 0…100, and what became of it, with COMMAND_ACK.result_param2. Each sends a frame; the
 * outbox has room (asserted).
 */
void mavlink_command_progress(const struct mavlink_context *context, uint8_t percent);
void mavlink_command_done(const struct mavlink_context *context, uint8_t result, int32_t detail);

/* Tells a change on every link whose stream of an ON_CHANGE message is not off, soon. */
void mavlink_changed(const struct mavlink_context *context);

#endif
