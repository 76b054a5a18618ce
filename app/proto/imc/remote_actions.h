/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The texts of RemoteActions and RemoteActionsRequest: "Name=value;Name=value", read without
 * floating point. Pairs may also be separated by commas. Names that are not ours are skipped.
 *
 * Context: any; no state.
 */
#ifndef PHAROS_PROTO_IMC_REMOTE_ACTIONS_H
#define PHAROS_PROTO_IMC_REMOTE_ACTIONS_H

#include "core/remote.h"
#include "proto/imc/messages.h"

#include <stdbool.h>

/* What a device with, or without, a gimbal takes, and in which range values are told. Constant. */
const char *imc_remote_actions_report(bool gimbal, bool decimal);

/*
 * An update into *input; what it does not name is 0. decimal: values are -1…1, else -127…127.
 * False: a value of ours is no number or out of range; *input is of no use.
 */
bool imc_remote_actions_parse(const struct imc_text *actions, bool decimal,
                              struct remote_input *input);

/* Ranges=Decimal or Ranges=Range127 among the pairs sets *decimal; nothing of it leaves it. */
void imc_remote_actions_ranges(const struct imc_text *actions, bool *decimal);

#endif
