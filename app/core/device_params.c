/* SPDX-License-Identifier: Apache-2.0 */
/* The device's parameters, and the security table that stands on them. */
#include "core/device.h"
#include "core/device_internal.h"

/* --- the security table ----------------------------------------------------------------------- */

bool pharos_device_may(const struct pharos_device *self, const struct device_who *who,
                       enum security_right right)
{
	return security_check(&self->security, who->way, right) == SECURITY_GRANTED;
}

/* --- parameters ------------------------------------------------------------------------------- */

static void configure_lamps(struct pharos_device *self, int64_t now_us)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_CONFIG};

	params_illuminator(&self->params, &event.config);
	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		(void)device_step_lamp(self, now_us, lamp, &event);
	}
}

static void configure_arbiters(struct pharos_device *self)
{
	struct arbiter_config config;

	params_arbiter(&self->params, &config);
	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		arbiter_configure(&self->lamps[lamp].arbiter, &config);
	}
#ifdef CONFIG_PHAROS_GIMBAL
	config = device_gimbal_arbiter_config(&self->params);
	arbiter_configure(&self->gimbal_arbiter, &config);
#endif
}

/* Who may do what has changed. */
static void follow_security(struct pharos_device *self, int64_t now_us)
{
	params_security(&self->params, &self->security);
#ifdef CONFIG_PHAROS_IMC
	device_lapse(self, now_us);
#else
	(void)now_us;
#endif
}

void pharos_device_set_keyed(struct pharos_device *self, int64_t now_us, bool has_key)
{
	if (self->security.has_key != has_key) {
		self->security.has_key = has_key;
		follow_security(self, now_us);
	}
}

/* In force here; what lies outside the core finds it in the effects. */
static void follow_params(struct pharos_device *self, int64_t now_us,
                          const struct param_set *changed)
{
	if (param_set_is_empty(changed)) {
		return;
	}
	param_set_merge(&device_effects_of(self)->params, changed);
	if (param_set_touches(changed, PARAM_GROUP_LIGHT)) {
		configure_lamps(self, now_us);
	}
	if (param_set_touches(changed, PARAM_GROUP_ARBITER)) {
		configure_arbiters(self);
	}
	if (param_set_touches(changed, PARAM_GROUP_ARBITER) ||
	    param_set_touches(changed, PARAM_GROUP_MAVLINK)) {
		follow_security(self, now_us);
	}
#ifdef CONFIG_PHAROS_GIMBAL
	if (self->has_gimbal && param_set_touches(changed, PARAM_GROUP_GIMBAL)) {
		struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG};

		params_gimbal(&self->params, &event.config);
		(void)gimbal_step(&self->gimbal, now_us, &event);
	}
#endif
#ifdef CONFIG_PHAROS_IMC
	if (param_set_touches(changed, PARAM_GROUP_OUTPUTS)) {
		struct thruster_config config;

		params_thruster(&self->params, &config);
		thruster_configure(&self->actuators.thruster, &config);
	}
#endif
}

enum params_result pharos_device_set_param(struct pharos_device *self, int64_t now_us,
                                           const struct device_who *who, uint32_t index,
                                           int32_t value)
{
	struct param_set changed;
	enum params_result result;

	if (index < PARAM_COUNT && !pharos_device_may(self, who, params_right(index))) {
		return PARAMS_FORBIDDEN;
	}
	result = params_set(&self->params, index, value, &changed);
	follow_params(self, now_us, &changed);
	return result;
}

bool pharos_device_reset_params(struct pharos_device *self, int64_t now_us,
                                const struct device_who *who)
{
	struct param_set changed;

	if (!pharos_device_may(self, who, SECURITY_SUPERVISION) ||
	    !pharos_device_may(self, who, SECURITY_LOCK)) {
		return false;
	}
	changed = params_reset(&self->params);
	follow_params(self, now_us, &changed);
	return true;
}
