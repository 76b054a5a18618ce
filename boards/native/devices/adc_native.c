/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_adc_native

#include <zephyr/device.h>
#include <zephyr/drivers/adc.h>

#include "host/clock.h"
#include "models/board.h"

#define RESOLUTION_MIN 6
#define RESOLUTION_MAX 16

struct adc_native_data {
	uint32_t configured; /* channels */
};

static int adc_native_channel_setup(const struct device *dev, const struct adc_channel_cfg *cfg)
{
	struct adc_native_data *data = dev->data;

	if (cfg->channel_id >= BOARD_ADC_COUNT) {
		return -EINVAL;
	}
	if (cfg->differential || cfg->acquisition_time != ADC_ACQ_TIME_DEFAULT) {
		return -ENOTSUP;
	}
	data->configured |= BIT(cfg->channel_id);
	return 0;
}

static int check(const struct adc_native_data *data, const struct adc_sequence *sequence,
                 unsigned int rounds, unsigned int stride)
{
	const struct adc_sequence_options *options = sequence->options;

	if (sequence->channels == 0 || (sequence->channels & ~data->configured) != 0 ||
	    sequence->resolution < RESOLUTION_MIN || sequence->resolution > RESOLUTION_MAX) {
		return -EINVAL;
	}
	if (sequence->oversampling != 0 || sequence->calibrate ||
	    (options != NULL && (options->callback != NULL || options->interval_us != 0))) {
		return -ENOTSUP;
	}
	return sequence->buffer_size < rounds * stride * sizeof(uint16_t) ? -ENOMEM : 0;
}

/* Conversions take no time here: in virtual time no time passes while code runs. */
static int adc_native_read(const struct device *dev, const struct adc_sequence *sequence)
{
	const unsigned int rounds =
		1u + (sequence->options != NULL ? sequence->options->extra_samplings : 0u);
	const unsigned int stride = (unsigned int)__builtin_popcount(sequence->channels);
	uint16_t *codes = sequence->buffer;
	int rc = check(dev->data, sequence, rounds, stride);

	for (uint32_t channel = 0; rc == 0 && channel < BOARD_ADC_COUNT; channel++) {
		if ((sequence->channels & BIT(channel)) == 0) {
			continue;
		}
		if (board_adc_convert((int64_t)clock_board_us(), channel, sequence->resolution,
		                      codes++, rounds, stride) != 0) {
			rc = -EINVAL;
		}
	}
	return rc;
}

static int adc_native_init(const struct device *dev)
{
	return 0;
}

static const struct adc_driver_api adc_native_api = {
	.channel_setup = adc_native_channel_setup,
	.read = adc_native_read,
};

#define ADC_NATIVE_DEFINE(inst)                                                                    \
	static struct adc_native_data adc_native_data_##inst;                                      \
	DEVICE_DT_INST_DEFINE(inst, adc_native_init, NULL, &adc_native_data_##inst, NULL,          \
	                      POST_KERNEL, 40, &adc_native_api);

DT_INST_FOREACH_STATUS_OKAY(ADC_NATIVE_DEFINE)
