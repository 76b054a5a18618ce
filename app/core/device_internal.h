/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of core/device share. Nobody else includes it. */
#ifndef PHAROS_CORE_DEVICE_INTERNAL_H
#define PHAROS_CORE_DEVICE_INTERNAL_H

#include "core/device.h"

/* To add to: something is to be performed, or told. */
struct device_effects *device_effects_of(struct pharos_device *self);

/* A step of a lamp, and the effects that follow. */
enum illuminator_result device_step_lamp(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                                         const struct illuminator_event *event);

#ifdef CONFIG_PHAROS_GIMBAL
/* The same sources as the lamp's, and the same ranks; silence changes nothing. */
struct arbiter_config device_gimbal_arbiter_config(const struct params *params);
#endif

#ifdef CONFIG_PHAROS_IMC
/* Schedules, and a power-down that goes on, of who may not have them any more. */
void device_lapse(struct pharos_device *self, int64_t now_us);
#endif

#endif
