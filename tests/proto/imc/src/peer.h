/* SPDX-License-Identifier: Apache-2.0 */
/* A device with an IMC endpoint, and a peer that sends to it and reads what it sends. */
#ifndef PHAROS_TESTS_PROTO_IMC_PEER_H
#define PHAROS_TESTS_PROTO_IMC_PEER_H

#include "proto/imc/endpoint.h"

/* Ids on the wire: the device's, and those of peers. */
#define DEVICE  0x8442
#define VEHICLE 0x4001

/* The links of the device: a stream, and datagrams. */
#define STREAM    1
#define DATAGRAMS 4

extern struct pharos_device device;
extern struct params *const params;   /* the device's */
extern struct device_effects effects; /* of the last packet or step */
extern struct imc_endpoint endpoint;
extern struct imc_outbox out;
extern int64_t now_us;

/*
 * A device that has just started, at time 0. services NULL: no datagrams. It has a gimbal, and of
 * outputs what device_board says.
 */
extern struct device_config device_board;
void device_start(const char *services);

/* From VEHICLE's entity 7 to all entities of the device, unless changed before each send(). */
extern struct imc_header header;
extern struct imc_route route;

/* The endpoint receives it. */
void send(const struct imc_message *message);

/* Goes to that time from deadline to deadline; how many packets of that id went out meanwhile. */
uint32_t pass(int64_t until_us, uint16_t id);

/* How many packets of that id are in the outbox; and the i-th of them, decoded. */
uint32_t count(uint16_t id);
const struct imc_packet *sent(uint16_t id, uint32_t index);
const struct imc_outbox_packet *sent_to(uint16_t id, uint32_t index);

struct imc_text text(const char *string);

#endif
