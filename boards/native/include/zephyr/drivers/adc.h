/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Analogue inputs, by Zephyr's names. adc_read() takes one sample of each channel in the sequence's
 * mask, and as many more rounds as its options ask for, into a buffer of 16-bit codes. Thread
 * context; 0 or -errno (-EINVAL: no such channel or resolution; -ENOMEM: buffer too small;
 * -ENOTSUP: an option it lacks). adc_read_async() begins that and returns; the signal is raised
 * with the result when it is done. Either waits, without end, for a request that is under way.
 */
#ifndef ZEPHYR_DRIVERS_ADC_H_
#define ZEPHYR_DRIVERS_ADC_H_

#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/dt-bindings/adc/adc.h>
#include <zephyr/kernel.h>

/* BIT() is in Zephyr's header too; the mask of channels is built with it */
#include <zephyr/sys/util.h>

enum adc_gain {
	ADC_GAIN_1,
};

enum adc_reference {
	ADC_REF_VDD_1,
};

struct adc_channel_cfg {
	enum adc_gain gain;
	enum adc_reference reference;
	uint16_t acquisition_time;
	uint8_t channel_id : 5;
	uint8_t differential : 1;
};

struct adc_dt_spec {
	const struct device *dev;
	uint8_t channel_id;
	bool channel_cfg_dt_node_exists;
	struct adc_channel_cfg channel_cfg;
	uint16_t vref_mv;
	uint8_t resolution;
	uint8_t oversampling;
};

struct adc_sequence_options {
	uint32_t interval_us; /* between rounds; 0: as fast as possible */
	void *callback;       /* must be NULL here */
	uint16_t extra_samplings;
};

struct adc_sequence {
	const struct adc_sequence_options *options; /* NULL: one round */
	uint32_t channels;
	void *buffer;
	size_t buffer_size; /* bytes */
	uint8_t resolution; /* bits */
	uint8_t oversampling;
	bool calibrate;
};

struct adc_driver_api {
	int (*channel_setup)(const struct device *dev, const struct adc_channel_cfg *cfg);
	int (*read)(const struct device *dev, const struct adc_sequence *sequence);
	int (*read_async)(const struct device *dev, const struct adc_sequence *sequence,
	                  struct k_poll_signal *async);
};

/* The controller's child node with the channel's number as its unit address gives the settings. */
#define NATIVE_ADC_CHANNEL_NODE(node_id, idx)                                                      \
	NATIVE_DT_CAT3(DT_IO_CHANNELS_CTLR_BY_IDX(node_id, idx), _CHILD_AT_,                       \
	               DT_IO_CHANNELS_INPUT_BY_IDX(node_id, idx))
#define NATIVE_ADC_CHANNEL_FIELDS(channel)                                                         \
	.channel_cfg_dt_node_exists = true,                                                        \
	.channel_cfg =                                                                             \
		{                                                                                  \
			.gain = DT_STRING_TOKEN(channel, zephyr_gain),                             \
			.reference = DT_STRING_TOKEN(channel, zephyr_reference),                   \
			.acquisition_time = DT_PROP(channel, zephyr_acquisition_time),             \
			.channel_id = DT_REG_ADDR(channel),                                        \
	},                                                                                         \
	.resolution = DT_PROP(channel, zephyr_resolution)
#define ADC_DT_SPEC_GET_BY_IDX(node_id, idx)                                                       \
	{                                                                                          \
		.dev = DEVICE_DT_GET(DT_IO_CHANNELS_CTLR_BY_IDX(node_id, idx)),                    \
		.channel_id = DT_IO_CHANNELS_INPUT_BY_IDX(node_id, idx),                           \
		NATIVE_ADC_CHANNEL_FIELDS(NATIVE_ADC_CHANNEL_NODE(node_id, idx)),                  \
	}
#define ADC_DT_SPEC_GET(node_id)               ADC_DT_SPEC_GET_BY_IDX(node_id, 0)
#define ADC_DT_SPEC_INST_GET_BY_IDX(inst, idx) ADC_DT_SPEC_GET_BY_IDX(DT_DRV_INST(inst), idx)
#define ADC_DT_SPEC_INST_GET(inst)             ADC_DT_SPEC_GET_BY_IDX(DT_DRV_INST(inst), 0)

static inline int adc_channel_setup(const struct device *dev, const struct adc_channel_cfg *cfg)
{
	return ((const struct adc_driver_api *)dev->api)->channel_setup(dev, cfg);
}

static inline int adc_read(const struct device *dev, const struct adc_sequence *sequence)
{
	return ((const struct adc_driver_api *)dev->api)->read(dev, sequence);
}

static inline int adc_read_async(const struct device *dev, const struct adc_sequence *sequence,
                                 struct k_poll_signal *async)
{
	return ((const struct adc_driver_api *)dev->api)->read_async(dev, sequence, async);
}

static inline int adc_channel_setup_dt(const struct adc_dt_spec *spec)
{
	return spec->channel_cfg_dt_node_exists ? adc_channel_setup(spec->dev, &spec->channel_cfg)
	                                        : -ENOTSUP;
}

/* Sets the sequence's channels, resolution and oversampling from the devicetree. */
static inline int adc_sequence_init_dt(const struct adc_dt_spec *spec, struct adc_sequence *seq)
{
	if (!spec->channel_cfg_dt_node_exists) {
		return -ENOTSUP;
	}
	seq->channels = BIT(spec->channel_id);
	seq->resolution = spec->resolution;
	seq->oversampling = spec->oversampling;
	return 0;
}

#endif
