/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the files of the actuation service share. See actuation.h.
 */
#ifndef PHAROS_PROTO_IMC_ACTUATION_INTERNAL_H
#define PHAROS_PROTO_IMC_ACTUATION_INTERNAL_H

#include "proto/imc/actuation.h"
#include "proto/imc/actuation_map.h"
#include "proto/imc/entities.h"

/* A packet on its way through one of the functions below. */
struct imc_turn {
	int64_t now_us;
	const struct imc_packet *packet;
	struct imc_outbox *out;
};

/* Who commands, and the lamp that the names are of. */
extern const struct device_who imc_who;
#define IMC_LAMP 0

static inline const struct illuminator *imc_lamp_of(const struct imc_actuation *self)
{
	return &self->device->lamps[IMC_LAMP].illuminator;
}

/* What became of a verb. */
enum imc_actuation_outcome imc_actuation_outcome_of(enum device_result result);

/* A command to an output. */
enum imc_actuation_outcome imc_actuation_drive(struct imc_actuation *self, int64_t now_us,
                                               const struct actuators_event *event);

static inline bool imc_mask_has(uint32_t mask, uint8_t number)
{
	return (mask & (1u << number)) != 0;
}

/* To the packet's sender. */
void imc_turn_reply(const struct imc_turn *turn, enum imc_entity entity,
                    const struct imc_message *message);

/* NULL: not on this board. What was asked for is kept for the log. */
const struct imc_map_row *imc_actuation_find_name(struct imc_actuation *self,
                                                  enum imc_map_space space,
                                                  const struct imc_text *name);
const struct imc_map_row *imc_actuation_find_id(struct imc_actuation *self,
                                                enum imc_map_space space, uint8_t id);

/* A function for each message that is received. */
enum imc_actuation_outcome imc_actuation_take_camera_zoom(struct imc_actuation *self,
                                                          const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_set_thruster_actuation(struct imc_actuation *self,
                                                                     const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_set_servo_position(struct imc_actuation *self,
                                                                 const struct imc_turn *turn);
enum imc_actuation_outcome
imc_actuation_take_set_control_surface_deflection(struct imc_actuation *self,
                                                  const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_remote_actions_request(struct imc_actuation *self,
                                                                     const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_remote_actions(struct imc_actuation *self,
                                                             const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_lcd_control(struct imc_actuation *self,
                                                          const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_power_operation(struct imc_actuation *self,
                                                              const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_power_channel_control(struct imc_actuation *self,
                                                                    const struct imc_turn *turn);
enum imc_actuation_outcome
imc_actuation_take_query_power_channel_state(struct imc_actuation *self,
                                             const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_query_led_brightness(struct imc_actuation *self,
                                                                   const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_set_led_brightness(struct imc_actuation *self,
                                                                 const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_set_pwm(struct imc_actuation *self,
                                                      const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_gpio_state_get(struct imc_actuation *self,
                                                             const struct imc_turn *turn);
enum imc_actuation_outcome imc_actuation_take_gpio_state_set(struct imc_actuation *self,
                                                             const struct imc_turn *turn);

/* actuation_lamp.c. A command to the lamp. */
enum imc_actuation_outcome imc_actuation_set_lamp(struct imc_actuation *self, int64_t now_us,
                                                  const struct illuminator_settings *settings);
enum imc_actuation_outcome imc_actuation_dim_lamp(struct imc_actuation *self, int64_t now_us,
                                                  uint32_t brightness_ppm);
enum imc_actuation_outcome imc_actuation_pulse_lamp(struct imc_actuation *self, int64_t now_us,
                                                    const struct imc_pwm *pwm);

/* actuation_panel.c. Carries out what the remote calls for. */
enum imc_actuation_outcome imc_actuation_perform_remote(struct imc_actuation *self, int64_t now_us,
                                                        const struct remote_output *output);

#endif
