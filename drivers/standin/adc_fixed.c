/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_adc_fixed

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/adc.h>
#include <zephyr/kernel.h>

#include <pharos/compat.h>

#define CODE_BITS 12

struct adc_fixed_config {
	uint16_t code;
};

struct adc_fixed_data {
	uint32_t noise; /* state of a linear congruential generator */
};

static int adc_fixed_channel_setup(const struct device *dev, const struct adc_channel_cfg *channel)
{
	return channel->differential ? -ENOTSUP : 0;
}

/* The code, or its neighbour by the generator's highest bit. */
static uint16_t convert(const struct device *dev)
{
	const struct adc_fixed_config *config = dev->config;
	struct adc_fixed_data *data = dev->data;

	/* Knuth's and Lewis's generator (Numerical Recipes) */
	data->noise = data->noise * 1664525u + 1013904223u;
	return config->code ^ (uint16_t)(data->noise >> 31);
}

static int adc_fixed_read(const struct device *dev, const struct adc_sequence *sequence)
{
	const size_t count =
		1u + (sequence->options != NULL ? sequence->options->extra_samplings : 0);
	uint16_t *codes = sequence->buffer;

	if (sequence->resolution != CODE_BITS) {
		return -ENOTSUP;
	}
	if (sequence->buffer_size < count * sizeof(codes[0])) {
		return -ENOMEM;
	}
	for (size_t i = 0; i < count; i++) {
		codes[i] = convert(dev);
	}
	return 0;
}

#ifdef CONFIG_ADC_ASYNC
static int adc_fixed_read_async(const struct device *dev, const struct adc_sequence *sequence,
                                struct k_poll_signal *async)
{
	const int rc = adc_fixed_read(dev, sequence);

	return rc != 0 ? rc : k_poll_signal_raise(async, 0);
}
#endif

static DEVICE_API(adc, adc_fixed_api) = {
	.channel_setup = adc_fixed_channel_setup,
	.read = adc_fixed_read,
#ifdef CONFIG_ADC_ASYNC
	.read_async = adc_fixed_read_async,
#endif
};

#define ADC_FIXED_DEFINE(inst)                                                                     \
	BUILD_ASSERT(DT_INST_PROP(inst, code) < (1 << CODE_BITS), "a code has 12 bits");           \
	static struct adc_fixed_data adc_fixed_data_##inst;                                        \
	static const struct adc_fixed_config adc_fixed_config_##inst = {                           \
		.code = DT_INST_PROP(inst, code),                                                  \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, NULL, NULL, &adc_fixed_data_##inst, &adc_fixed_config_##inst,  \
	                      POST_KERNEL, CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &adc_fixed_api);

DT_INST_FOREACH_STATUS_OKAY(ADC_FIXED_DEFINE)
