/* SPDX-License-Identifier: Apache-2.0 */
/*
 * IMC's actuation group; sans-IO. What each message means on this device is the table in
 * actuation_map.c; docs/imc.md tells it to people.
 *
 * The lamp and what is beside it (core/actuators.h) are stepped here; the owner then performs
 * imc_actuation.effects and the actuators' outputs: IMC_ACTION_ACTUATE asks for it. That is before
 * the answers go out, and before the next call.
 *
 * A name or an id that is not on this board, a value that is no number or out of range, a command
 * that the arbiter or the lamp refuses: nothing changes, a counter, imc_actuation.refusal for the
 * log. Only of an LED and a GPIO line the present value is the answer to a refused command; any
 * other one has none.
 *
 * Context: the command thread. Spec: IMC 5.4.31, 300…316 and 2000…2002.
 */
#ifndef PHAROS_PROTO_IMC_ACTUATION_H
#define PHAROS_PROTO_IMC_ACTUATION_H

#include "core/actuators.h"
#include "core/arbiter.h"
#include "core/illuminator.h"
#include "core/remote.h"
#include "proto/imc/codec.h"
#include "proto/imc/outbox.h"

#include <stdbool.h>
#include <stdint.h>

/* An axis of the gimbal: an angle in mdeg, or a rate in ppm of the fastest. */
enum imc_aim_kind {
	IMC_AIM_KEEP,
	IMC_AIM_ANGLE,
	IMC_AIM_RATE,
};

struct imc_aim {
	enum imc_aim_kind kind;
	int32_t value;
};

enum imc_axis {
	IMC_AXIS_PAN,
	IMC_AXIS_TILT,
	IMC_AXES,
};

/* Of the last call: the lamp's actions, in this order, and where the gimbal shall turn. */
struct imc_actuation_effects {
	struct illuminator_outbox command;
	struct illuminator_outbox power;
	struct imc_aim aim[IMC_AXES];
};

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
	struct illuminator *illuminator;
	struct arbiter *arbiter;
	struct actuators actuators;
	struct remote remote;
	struct imc_actuation_effects effects;
	struct imc_actuation_stats stats;
	struct imc_actuation_refusal refusal;
	uint32_t gpio_inputs;      /* levels: the owner keeps them up to date */
	bool gimbal;               /* the board has one */
	bool decimal;              /* the remote tells shares as decimals, not of 127 */
	uint32_t strobe_period_us; /* what the remote's strobe button brings back */
	uint32_t strobe_duty_ppm;
};

/* illuminator and arbiter are kept by reference. */
void imc_actuation_init(struct imc_actuation *self, int64_t now_us,
                        const struct actuators_config *config, bool gimbal,
                        struct illuminator *illuminator, struct arbiter *arbiter);

/* A packet for us or for everyone. Messages of other groups are ignored. Adds to *out. */
void imc_actuation_receive(struct imc_actuation *self, int64_t now_us,
                           const struct imc_packet *packet, struct imc_outbox *out);

/* At its deadline or before. Adds to *out. */
void imc_actuation_step(struct imc_actuation *self, int64_t now_us, struct imc_outbox *out);
int64_t imc_actuation_deadline_us(const struct imc_actuation *self);

/* A command for a power channel from elsewhere, as power_command(); the lamp's is a command to the
 * lamp. False: there, or by the arbiter, refused. */
bool imc_actuation_power(struct imc_actuation *self, int64_t now_us, enum arbiter_source source,
                         uint32_t channel, uint32_t op);

/* Whether this board has what a row of the map says. */
bool imc_actuation_has(const struct imc_actuation *self, const struct imc_map_row *row);

/* A button of the device has been pressed or released: tells everyone. Adds to *out. */
void imc_actuation_button(uint8_t button, bool pressed, struct imc_outbox *out);

#endif
