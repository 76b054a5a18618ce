/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Display and remote of the actuation service.
 */
#include "proto/imc/actuation_internal.h"
#include "proto/imc/remote_actions.h"

enum imc_actuation_outcome imc_actuation_take_lcd_control(struct imc_actuation *self,
                                                          const struct imc_turn *turn)
{
	const struct imc_lcd_control *const set = &turn->packet->message.lcd_control;

	const struct actuators_event event = {
		.kind = ACTUATORS_EVENT_DISPLAY,
		.display = {set->op, set->text.bytes, set->text.length},
	};

	return self->device->actuators.config.display
	               ? imc_actuation_drive(self, turn->now_us, &event)
	               : IMC_ACTUATION_UNKNOWN;
}

enum imc_actuation_outcome imc_actuation_take_remote_actions_request(struct imc_actuation *self,
                                                                     const struct imc_turn *turn)
{
	const struct imc_remote_actions_request *const request =
		&turn->packet->message.remote_actions_request;

	switch (request->op) {
	case IMC_REMOTE_ACTIONS_QUERY:
		break;
	case IMC_REMOTE_ACTIONS_REGISTER:
		imc_remote_actions_ranges(&request->actions, &self->decimal);
		return IMC_ACTUATION_DONE;
	case IMC_REMOTE_ACTIONS_REPORT:
		return IMC_ACTUATION_DONE; /* somebody else's */
	default:
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const struct imc_message message = {
		.id = IMC_REMOTE_ACTIONS_REQUEST,
		.remote_actions_request = {.op = IMC_REMOTE_ACTIONS_REPORT,
	                                   .actions = imc_text_of(imc_remote_actions_report(
						   pharos_device_has_gimbal(self->device),
						   self->decimal))},
	};

	imc_turn_reply(turn, IMC_ENTITY_PANEL, &message);
	return IMC_ACTUATION_DONE;
}

/* On with what it was before, within what parameters allow now; off and that is remembered. */
static void toggle_strobe(struct imc_actuation *self, struct illuminator_settings *settings)
{
	const struct illuminator_config *const config = &imc_lamp_of(self)->config;

	if (settings->strobe_period_us != 0 && settings->duty_ppm != 0 &&
	    settings->duty_ppm != PPM_ONE) {
		self->strobe_period_us = settings->strobe_period_us;
		self->strobe_duty_ppm = settings->duty_ppm;
		settings->strobe_period_us = 0;
		settings->duty_ppm = PPM_ONE;
		return;
	}
	settings->strobe_period_us = self->strobe_period_us;
	settings->duty_ppm = self->strobe_duty_ppm;
	if (settings->strobe_period_us < config->min_period_us) {
		settings->strobe_period_us = config->min_period_us;
	} else if (settings->strobe_period_us > config->max_period_us) {
		settings->strobe_period_us = config->max_period_us;
	}
}

static struct gimbal_aim rate_of(const struct imc_actuation *self, enum gimbal_axis_id axis,
                                 int32_t share_ppm)
{
	return (struct gimbal_aim){
		.kind = GIMBAL_RATE,
		.value = pharos_device_share_rate(self->device, axis, share_ppm),
	};
}

static enum imc_actuation_outcome move(struct imc_actuation *self, int64_t now_us,
                                       const struct remote_output *output)
{
	const struct gimbal_event event = {
		.kind = GIMBAL_EVENT_AIM,
		.aim =
			{
				[GIMBAL_PAN] = rate_of(self, GIMBAL_PAN, output->pan_ppm),
				[GIMBAL_TILT] = rate_of(self, GIMBAL_TILT, output->tilt_ppm),
			},
	};

	return imc_actuation_outcome_of(
		pharos_device_point(self->device, now_us, &imc_who, &event));
}

enum imc_actuation_outcome imc_actuation_perform_remote(struct imc_actuation *self, int64_t now_us,
                                                        const struct remote_output *output)
{
	struct illuminator_settings settings = imc_lamp_of(self)->settings;
	enum imc_actuation_outcome outcome = IMC_ACTUATION_DONE;

	if (output->move && pharos_device_has_gimbal(self->device)) {
		outcome = move(self, now_us, output);
	}
	if (output->toggle_strobe) {
		toggle_strobe(self, &settings);
	}
	if (output->set_brightness) {
		settings.brightness_ppm = output->brightness_ppm;
	}
	if (output->toggle_light) {
		settings.enable = !settings.enable;
	}
	if (output->toggle_strobe || output->set_brightness || output->toggle_light) {
		const enum imc_actuation_outcome lamp =
			imc_actuation_set_lamp(self, now_us, &settings);

		outcome = lamp != IMC_ACTUATION_DONE ? lamp : outcome;
	}
	return outcome;
}

enum imc_actuation_outcome imc_actuation_take_remote_actions(struct imc_actuation *self,
                                                             const struct imc_turn *turn)
{
	const struct imc_text *const actions = &turn->packet->message.remote_actions.actions;
	struct remote_input input;

	imc_remote_actions_ranges(actions, &self->decimal);
	if (!imc_remote_actions_parse(actions, self->decimal, &input)) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const struct remote_output output = remote_update(&self->remote, turn->now_us, &input);

	return imc_actuation_perform_remote(self, turn->now_us, &output);
}
