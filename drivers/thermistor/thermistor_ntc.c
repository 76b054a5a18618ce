/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_thermistor_ntc

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/adc.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/util.h>

#include <pharos/drivers/thermistor.h>

#include "ntc_math.h"

#define OVERSAMPLING_MAX 64

/* Nearer than this to a rail is a broken or shorted wire: no temperature of a lamp is there. */
#define RAIL_PERCENT 1

/* All conversions of a sample take a converter less than 10 ms. */
#define CONVERSION_MS 100

struct thermistor_ntc_config {
	struct adc_dt_spec adc;
	struct ntc_divider divider;
	uint8_t oversampling;
};

/* What the converter writes to lies here, not on a stack: it may come back after the time-out. */
struct thermistor_ntc_data {
	struct k_poll_signal done;
	struct adc_sequence_options options;
	uint16_t codes[OVERSAMPLING_MAX];
	bool silent; /* it did not answer: another request could wait for ever for the first one */
};

static int wait_done(struct thermistor_ntc_data *data)
{
	struct k_poll_event event =
		K_POLL_EVENT_INITIALIZER(K_POLL_TYPE_SIGNAL, K_POLL_MODE_NOTIFY_ONLY, &data->done);
	unsigned int signaled;
	int result;

	if (k_poll(&event, 1, K_MSEC(CONVERSION_MS)) != 0) {
		data->silent = true;
		return -ETIMEDOUT;
	}
	k_poll_signal_check(&data->done, &signaled, &result);
	return result;
}

static int convert(const struct device *dev)
{
	const struct thermistor_ntc_config *config = dev->config;
	struct thermistor_ntc_data *data = dev->data;
	struct adc_sequence sequence = {
		.options = &data->options,
		.buffer = data->codes,
		.buffer_size = config->oversampling * sizeof(data->codes[0]),
	};
	int rc;

	if (data->silent) {
		return -ETIMEDOUT;
	}
	data->options.extra_samplings = config->oversampling - 1u;
	rc = adc_sequence_init_dt(&config->adc, &sequence);
	if (rc != 0) {
		return rc;
	}
	k_poll_signal_reset(&data->done);
	rc = adc_read_async(config->adc.dev, &sequence, &data->done);
	return rc != 0 ? rc : wait_done(data);
}

static int thermistor_ntc_sample(const struct device *dev, struct thermistor_sample *sample)
{
	const struct thermistor_ntc_config *config = dev->config;
	const struct thermistor_ntc_data *data = dev->data;
	const uint32_t full = ((1u << config->adc.resolution) - 1u) * config->oversampling;
	const uint32_t margin = (full * RAIL_PERCENT) / 100u;
	uint32_t sum = 0;
	const int rc = convert(dev);

	if (rc != 0) {
		return rc;
	}
	for (size_t i = 0; i < config->oversampling; i++) {
		sum += data->codes[i];
	}
	sample->raw = sum;
	sample->raw_max = full;
	sample->temp_mdegc = 0;
	if (sum > full - margin) {
		sample->status = THERMISTOR_OPEN;
	} else if (sum < margin) {
		sample->status = THERMISTOR_SHORT;
	} else {
		sample->status = THERMISTOR_OK;
		sample->temp_mdegc = ntc_temp_mdegc(&config->divider, sum, full);
	}
	return 0;
}

static int thermistor_ntc_init(const struct device *dev)
{
	const struct thermistor_ntc_config *config = dev->config;
	struct thermistor_ntc_data *data = dev->data;

	k_poll_signal_init(&data->done);
	if (!device_is_ready(config->adc.dev)) {
		return -ENODEV;
	}
	return adc_channel_setup_dt(&config->adc);
}

static const struct thermistor_driver_api thermistor_ntc_api = {
	.sample = thermistor_ntc_sample,
};

#define THERMISTOR_NTC_DEFINE(inst)                                                                \
	BUILD_ASSERT(DT_INST_PROP(inst, oversampling) >= 1 &&                                      \
	                     DT_INST_PROP(inst, oversampling) <= OVERSAMPLING_MAX,                 \
	             "oversampling must be 1 to 64");                                              \
	BUILD_ASSERT(DT_INST_PROP(inst, pullup_ohms) > 0 && DT_INST_PROP(inst, r25_ohms) > 0,      \
	             "a resistance must be above 0");                                              \
	BUILD_ASSERT(DT_INST_PROP(inst, beta_kelvin) >= 1000 &&                                    \
	                     DT_INST_PROP(inst, beta_kelvin) <= 10000,                             \
	             "beta must be 1000 to 10000 K");                                              \
	static struct thermistor_ntc_data thermistor_ntc_data_##inst;                              \
	static const struct thermistor_ntc_config thermistor_ntc_config_##inst = {                 \
		.adc = ADC_DT_SPEC_INST_GET(inst),                                                 \
		.divider =                                                                         \
			{                                                                          \
				.pullup_ohms = DT_INST_PROP(inst, pullup_ohms),                    \
				.r25_ohms = DT_INST_PROP(inst, r25_ohms),                          \
				.beta_k = DT_INST_PROP(inst, beta_kelvin),                         \
			},                                                                         \
		.oversampling = DT_INST_PROP(inst, oversampling),                                  \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, thermistor_ntc_init, NULL, &thermistor_ntc_data_##inst,        \
	                      &thermistor_ntc_config_##inst, POST_KERNEL,                          \
	                      CONFIG_PHAROS_DRIVERS_INIT_PRIORITY, &thermistor_ntc_api);

DT_INST_FOREACH_STATUS_OKAY(THERMISTOR_NTC_DEFINE)
