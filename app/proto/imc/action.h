/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What IMC asks of the device, beside packets; the command thread performs it.
 */
#ifndef PHAROS_PROTO_IMC_ACTION_H
#define PHAROS_PROTO_IMC_ACTION_H

#include "core/params.h"

enum imc_action_kind {
	IMC_ACTION_PARAMS_CHANGED, /* changed: put in force, as core/params.h says, and store */
	IMC_ACTION_ACTUATE,        /* perform the actuation service's effects and outputs */
	IMC_ACTION_HEARD,          /* its sender is there: a sign of life for the arbiter */
};

struct imc_action {
	enum imc_action_kind kind;
	struct param_set changed;
};

#endif
