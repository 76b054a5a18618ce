/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What IMC asks of the device, beside packets; the command thread performs it.
 */
#ifndef PHAROS_PROTO_IMC_ACTION_H
#define PHAROS_PROTO_IMC_ACTION_H

#include "core/illuminator.h"
#include "core/params.h"

#include <stdbool.h>
#include <stdint.h>

enum imc_action_kind {
	IMC_ACTION_LAMP,           /* lamp: all events, in order, or none */
	IMC_ACTION_PARAMS_CHANGED, /* changed: put them in force, as core/params.h says; store them
	                            */
	IMC_ACTION_ACTUATE,        /* perform the actuation service's effects and outputs */
	IMC_ACTION_HEARD,          /* its sender is there: a sign of life for the arbiter */
};

/* repeated: the same as this source's command before; takes the light from nobody. */
struct imc_lamp_action {
	bool repeated;
	uint8_t events_count;
	struct illuminator_event events[2];
};

struct imc_action {
	enum imc_action_kind kind;
	union {
		struct imc_lamp_action lamp;
		struct param_set changed;
	};
};

#endif
