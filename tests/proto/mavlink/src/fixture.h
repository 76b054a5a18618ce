/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A light with system id 1, component id 243 on links 0 and 1, and a ground station 255/190 that
 * talks to it. Strobe periods 0.01 s to 10 s.
 */
#ifndef PHAROS_TESTS_MAVLINK_FIXTURE_H
#define PHAROS_TESTS_MAVLINK_FIXTURE_H

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/framer.h"
#include "proto/mavlink/illuminator_service.h"
#include "proto/mavlink/real.h"

#include <string.h>

#include <zephyr/ztest.h>

#define SECOND INT64_C(1000000)

extern struct pharos_device device;
extern struct illuminator *const light; /* the device's */
extern struct arbiter *const arbiter;
extern struct params *const device_params;
extern struct device_effects effects; /* of the last frame */
extern struct mavlink_illuminator service;
extern struct mavlink_endpoint endpoint;
extern struct mavlink_outbox out;
extern int64_t now_us;

/* Everything new, at time 0; nothing has been sent yet. Suits ZTEST_SUITE. */
void fixture_before(void *unused);

/* Takes the device's effects, of which the endpoint is told. */
void settle(void);

/* A frame arrives on a link. */
void receive(uint8_t link, const uint8_t *bytes, size_t length);

/* The ground station sends a message in version 2. */
void receive_message(uint8_t link, const struct mavlink_kind *kind, const void *payload);

/* A COMMAND_LONG to anyone; params beyond the fifth and seventh are 0. */
struct command_params {
	float p[7];
};
void receive_long(uint8_t link, uint8_t system, uint8_t component, uint16_t id,
                  struct command_params params);

/*
 * A COMMAND_LONG to the light on link 0, which must be answered by an acknowledgement to the ground
 * station and nothing before it. Returns the result.
 */
uint8_t command(uint16_t id, struct command_params params);
#define COMMAND(id, ...) command((id), (struct command_params){{__VA_ARGS__}})

/* Moves time on, stepping the endpoint whenever it wants; frames are counted, not kept. */
struct tally {
	uint32_t heartbeats[MAVLINK_LINKS_MAX];
	uint32_t statuses[MAVLINK_LINKS_MAX];
	uint32_t texts[MAVLINK_LINKS_MAX];
	uint32_t others[MAVLINK_LINKS_MAX];
	mavlink_illuminator_status_t last_status;
	mavlink_statustext_t last_text;
	mavlink_heartbeat_t last_heartbeat;
};
struct tally run_until(int64_t until_us);

/* Frame i of the outbox, and its payload. */
struct mavlink_frame sent(uint16_t i);
void sent_payload(uint16_t i, uint32_t id, void *payload, size_t size);

/* Frame i of the outbox is, byte for byte. */
void assert_sent(uint16_t i, uint8_t link, const uint8_t *bytes, size_t length);

/* The current ILLUMINATOR_STATUS, asked for. */
mavlink_illuminator_status_t status_now(void);

/* The thermal supervisor reports. */
void thermal_report(enum thermal_state state, enum thermal_fault fault, int32_t temp_mdegc);

#endif
