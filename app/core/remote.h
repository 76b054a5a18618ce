/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hand-held remote: two buttons, a slider and two axes, told as a whole several times a second.
 * What an update does not name is 0, and without an update for REMOTE_HOLD_US everything is.
 *
 * What 0 does: a button that is released and a slider that is let go do nothing, so the lamp stays
 * as it is; an axis at 0 stops. A press toggles the light, or its strobe. The slider sets the
 * brightness when it has moved to a value above 0, so that a resting one takes the lamp from
 * nobody. An axis is a speed, told with each update and every REMOTE_RENEW_US while it is not 0,
 * and once when it is 0 again: what it drives may stop by itself when it is not told for longer.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 305 RemoteActions.
 */
#ifndef PHAROS_CORE_REMOTE_H
#define PHAROS_CORE_REMOTE_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

struct remote_input {
	bool light;
	bool strobe;
	uint32_t brightness_ppm; /* 0…PPM_ONE */
	int32_t pan_ppm;         /* -PPM_ONE…PPM_ONE */
	int32_t tilt_ppm;
};

/* What an update, or its absence, calls for. */
struct remote_output {
	bool toggle_light;
	bool toggle_strobe;
	bool set_brightness; /* to brightness_ppm, 1…PPM_ONE */
	bool move;           /* with pan_ppm and tilt_ppm, of the axes' greatest speed; 0: stop */
	uint32_t brightness_ppm;
	int32_t pan_ppm;
	int32_t tilt_ppm;
};

struct remote {
	struct remote_input input;
	int64_t release_us; /* when everything returns to 0; TIME_NEVER_US: it has */
	int64_t renew_us;   /* when the axes are told again; TIME_NEVER_US: they stand still */
};

void remote_init(struct remote *self);

/* input as above (asserted). */
struct remote_output remote_update(struct remote *self, int64_t now_us,
                                   const struct remote_input *input);

/* What has fallen due: the axes once more, or everything being 0; else nothing. */
struct remote_output remote_advance(struct remote *self, int64_t now_us);
int64_t remote_deadline_us(const struct remote *self);

#endif
