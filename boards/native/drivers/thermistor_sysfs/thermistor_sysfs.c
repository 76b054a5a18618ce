/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp's temperature: of a sensor of the host (--thermistor), or of the board's model through
 * the NTC on its ADC.
 */
#define DT_DRV_COMPAT pharos_thermistor_sysfs

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/util.h>

#include <pharos/drivers/thermistor.h>

#include "thermistor/ntc_math.h"
#include "thermistor_sysfs.h"

/* A sensor that has not answered by then gives no sample; its answer is for the next one. */
#define WAIT_MS 50

/* As drivers/thermistor: nearer than this to a rail is a broken or shorted wire. */
#define RAIL_PERCENT 1

struct thermistor_sysfs_config {
	const struct device *model;
};

static struct {
	struct k_sem done;
	bool under_way;
	uint32_t count;
} state;

static void on_done(void)
{
	k_sem_give(&state.done);
}

static void judge_divider(const struct thermistor_sysfs_reading *reading,
                          struct thermistor_sample *sample)
{
	const struct ntc_divider divider = {
		.pullup_ohms = reading->pullup_ohms,
		.r25_ohms = reading->r25_ohms,
		.beta_k = reading->beta_k,
	};
	const uint32_t margin = (uint32_t)(((uint64_t)reading->full_uv * RAIL_PERCENT) / 100u);

	sample->raw = reading->sum_uv;
	sample->raw_max = reading->full_uv;
	sample->temp_mdegc = 0;
	if (reading->sum_uv > reading->full_uv - margin) {
		sample->status = THERMISTOR_OPEN;
	} else if (reading->sum_uv < margin) {
		sample->status = THERMISTOR_SHORT;
	} else {
		sample->status = THERMISTOR_OK;
		sample->temp_mdegc = ntc_temp_mdegc(&divider, reading->sum_uv, reading->full_uv);
	}
}

static int read_sensor(struct thermistor_sample *sample)
{
	const struct thermistor_sysfs_reading *const reading = thermistor_sysfs_reading();

	if (!state.under_way) {
		state.under_way = true;
		thermistor_sysfs_begin(on_done);
	}
	if (k_sem_take(&state.done, K_MSEC(WAIT_MS)) != 0) {
		return -ETIMEDOUT;
	}
	state.under_way = false;
	if (reading->error != 0) {
		return reading->error;
	}
	if (reading->is_divider) {
		judge_divider(reading, sample);
		return 0;
	}
	/* a digital sensor's value may rightly stand still */
	state.count++;
	*sample = (struct thermistor_sample){
		.status = THERMISTOR_OK,
		.temp_mdegc = reading->temp_mdegc,
		.raw = state.count,
		.raw_max = UINT32_MAX,
	};
	return 0;
}

static int thermistor_sysfs_sample(const struct device *dev, struct thermistor_sample *sample)
{
	const struct thermistor_sysfs_config *config = dev->config;

	return thermistor_sysfs_is_real() ? read_sensor(sample)
	                                  : thermistor_sample(config->model, sample);
}

static bool is_simulated(const struct device *dev)
{
	return thermistor_sysfs_is_simulated();
}

static int thermistor_sysfs_init(const struct device *dev)
{
	const struct thermistor_sysfs_config *config = dev->config;

	(void)k_sem_init(&state.done, 0, 1);
	if (thermistor_sysfs_is_missing()) {
		return -ENODEV;
	}
	return thermistor_sysfs_is_real() || device_is_ready(config->model) ? 0 : -ENODEV;
}

static const struct thermistor_driver_api thermistor_sysfs_api = {
	.sample = thermistor_sysfs_sample,
	.is_simulated = is_simulated,
};

BUILD_ASSERT(DT_NUM_INST_STATUS_OKAY(DT_DRV_COMPAT) == 1, "--thermistor is one option");

static const struct thermistor_sysfs_config thermistor_sysfs_config = {
	.model = DEVICE_DT_GET(DT_INST_PHANDLE(0, model)),
};

/* After its model's. */
DEVICE_DT_INST_DEFINE(0, thermistor_sysfs_init, NULL, NULL, &thermistor_sysfs_config, POST_KERNEL,
                      CONFIG_PHAROS_DRIVERS_INIT_PRIORITY + 1, &thermistor_sysfs_api);
