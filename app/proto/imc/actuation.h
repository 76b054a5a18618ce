/* SPDX-License-Identifier: Apache-2.0 */
/*
 * IMC's actuation group; sans-IO. What each message means on this device is the table in
 * actuation_map.c; docs/imc.md tells it to people. It becomes verbs of the device, whose effects
 * are performed before the answers go out.
 *
 * A name or an id that is not on this board, a value that is no number or out of range, a command
 * that the device refuses: nothing changes, a counter, imc_actuation.refusal for the log. Only of
 * an LED and a GPIO line the present value is the answer to a refused command; any other one has
 * none.
 *
 * Context: the command thread. Spec: IMC 5.4.31, 300…316 and 2000…2002.
 */
#ifndef PHAROS_PROTO_IMC_ACTUATION_H
#define PHAROS_PROTO_IMC_ACTUATION_H

#include "core/device.h"
#include "core/remote.h"
#include "proto/imc/codec.h"
#include "proto/imc/outbox.h"

#include <stdbool.h>
#include <stdint.h>

enum imc_actuation_outcome {
	IMC_ACTUATION_DONE,
	IMC_ACTUATION_UNKNOWN,      /* no such name or id on this board */
	IMC_ACTUATION_OUT_OF_RANGE, /* no number, out of range, an op that there isn't */
	IMC_ACTUATION_REFUSED,      /* valid, but not from IMC or not now */
};

struct imc_actuation_stats {
	uint32_t outcomes[IMC_ACTUATION_REFUSED +
	                  1]; /* commands and queries, by what became of them */
};

/* What became of the last call's message, for the log. */
struct imc_actuation_refusal {
	enum imc_actuation_outcome outcome;
	uint16_t id;
	uint8_t number;                        /* of the thing, where it has one */
	char name[IMC_ACTUATION_NAME_MAX + 1]; /* where it has one, cut off; else "" */
};

struct imc_map_row;

struct imc_actuation {
	struct pharos_device *device;
	struct remote remote;
	struct imc_actuation_stats stats;
	struct imc_actuation_refusal refusal;
	uint32_t gpio_inputs;      /* levels: the owner keeps them up to date */
	bool decimal;              /* the remote tells shares as decimals, not of 127 */
	uint32_t strobe_period_us; /* what the remote's strobe button brings back */
	uint32_t strobe_duty_ppm;
};

/* device: kept by reference. */
void imc_actuation_init(struct imc_actuation *self, struct pharos_device *device);

/* A packet for us or for everyone. Messages of other groups are ignored. Adds to *out. */
void imc_actuation_receive(struct imc_actuation *self, int64_t now_us,
                           const struct imc_packet *packet, struct imc_outbox *out);

/* At its deadline or before. */
void imc_actuation_step(struct imc_actuation *self, int64_t now_us);
int64_t imc_actuation_deadline_us(const struct imc_actuation *self);

/* Whether this board has what a row of the map says. */
bool imc_actuation_has(const struct imc_actuation *self, const struct imc_map_row *row);

/* The device powers down, or up: tells everyone. Adds to *out. */
void imc_actuation_tell(const struct shutdown_notice *notice, struct imc_outbox *out);

/* A button of the device has been pressed or released: tells everyone. Adds to *out. */
void imc_actuation_button(uint8_t button, bool pressed, struct imc_outbox *out);

#endif
