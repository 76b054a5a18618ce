/* SPDX-License-Identifier: Apache-2.0 */
/* The control operations of the host itself: hello, ops, wires, fault, reset, quit. */
#ifndef NATIVE_HOST_CONTROL_OPS_H_
#define NATIVE_HOST_CONTROL_OPS_H_

#include <stdbool.h>

#include "host/control.h"

extern const struct control_op control_ops[];

/* After a `quit`: the process is to end when its reply is out. */
bool control_quitting(void);

/* The kernel is idle for the first time after a `reset`: its reply is due. */
void control_after_reset(void);

#endif
