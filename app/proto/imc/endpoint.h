/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All of IMC for one device: node and services put together; sans-IO.
 *
 * A thread does this: each packet that imc_verify() found good into _receive(), _step() at the
 * deadline and after whatever was told. After each call it performs the device's effects, lets
 * _tell() know them, and sends the outbox's packets.
 *
 * The device has no calendar: its packets are stamped with the time of whoever announced itself or
 * sent a Heartbeat last, and with the time since boot before that.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_IMC_ENDPOINT_H
#define PHAROS_PROTO_IMC_ENDPOINT_H

#include "core/device.h"
#include "proto/imc/actuation.h"
#include "proto/imc/node.h"
#include "proto/imc/outbox.h"

#include <stdbool.h>
#include <stdint.h>

/* id: this device's; sensors have 0x8000…0x8FFF. */
struct imc_endpoint_config {
	struct imc_node_config node;
	uint16_t id;
};

struct imc_endpoint_stats {
	uint32_t packets; /* good ones, whoever they are for */
	uint32_t unknown_ids;
	uint32_t malformed;  /* payloads that are not of their message */
	uint32_t not_for_us; /* another dst, or an entity that we don't have */
	uint32_t own;        /* that came back, or another device has our id */
	uint32_t sent;
	uint32_t unsent; /* found no room in the outbox */
};

struct imc_endpoint {
	uint16_t id;
	int64_t unix_offset_us; /* Unix time less time since boot; 0: not known */
	struct imc_node node;
	struct imc_actuation actuation;
	struct imc_endpoint_stats stats;
	struct imc_packet packet; /* the one that is being received */
};

/* device: kept by reference. */
void imc_endpoint_init(struct imc_endpoint *self, int64_t now_us,
                       const struct imc_endpoint_config *config, struct pharos_device *device);

/* A button of the device has changed: everyone is told. *out is overwritten. */
void imc_endpoint_button(struct imc_endpoint *self, int64_t now_us, uint8_t button, bool pressed,
                         struct imc_outbox *out);

/* bytes: a whole packet, verified. route: where it came from. *out is overwritten. */
void imc_endpoint_receive(struct imc_endpoint *self, int64_t now_us, const struct imc_route *route,
                          const uint8_t *bytes, struct imc_outbox *out);

/* At its deadline or before. *out is overwritten. */
void imc_endpoint_step(struct imc_endpoint *self, int64_t now_us, struct imc_outbox *out);
int64_t imc_endpoint_deadline_us(const struct imc_endpoint *self);

/* What the device did becomes the states of its entities, and packets for everyone. Adds to *out.
 */
void imc_endpoint_tell(struct imc_endpoint *self, int64_t now_us,
                       const struct device_effects *effects, struct imc_outbox *out);

#endif
