/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_adc_native

#include <zephyr/device.h>
#include <zephyr/drivers/adc.h>
#include <zephyr/kernel.h>

#include "devices/fault.h"
#include "host/clock.h"
#include "models/board.h"

#define RESOLUTION_MIN 6
#define RESOLUTION_MAX 16

struct adc_native_data {
	const struct device *dev;
	uint32_t configured; /* channels */
	/* a request of Zephyr's adc_context: one that is not answered is in the way of the next */
	struct k_sem idle;
	struct k_sem done;
	struct k_timer timer;
	struct k_poll_signal *signal; /* NULL: adc_read() waits */
	struct adc_sequence sequence;
	int result;
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
static int convert(const struct device *dev, const struct adc_sequence *sequence)
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

/* The end of a request: only then the next one begins. */
static void finish(struct adc_native_data *data, int rc)
{
	struct k_poll_signal *const signal = data->signal;

	data->result = rc;
	k_sem_give(&data->idle);
	if (signal != NULL) {
		k_poll_signal_raise(signal, rc);
	} else {
		k_sem_give(&data->done);
	}
}

static void late(struct k_timer *timer)
{
	struct adc_native_data *const data = CONTAINER_OF(timer, struct adc_native_data, timer);

	finish(data, convert(data->dev, &data->sequence));
}

static void begin(const struct device *dev, const struct adc_sequence *sequence,
                  struct k_poll_signal *signal)
{
	const struct board_fault *const fault = fault_of(BOARD_CHIP_ADC);
	struct adc_native_data *const data = dev->data;

	k_sem_take(&data->idle, K_FOREVER);
	data->signal = signal;
	switch (fault->kind) {
	case BOARD_FAULT_NONE:
		finish(data, convert(dev, sequence));
		break;
	case BOARD_FAULT_ERROR:
		finish(data, -EIO);
		break;
	case BOARD_FAULT_LATE:
		data->sequence = *sequence;
		k_timer_start(&data->timer, K_USEC(fault->delay_us), K_NO_WAIT);
		break;
	case BOARD_FAULT_NEVER:
		break;
	}
}

static int adc_native_read(const struct device *dev, const struct adc_sequence *sequence)
{
	struct adc_native_data *const data = dev->data;

	begin(dev, sequence, NULL);
	k_sem_take(&data->done, K_FOREVER);
	return data->result;
}

static int adc_native_read_async(const struct device *dev, const struct adc_sequence *sequence,
                                 struct k_poll_signal *async)
{
	begin(dev, sequence, async);
	return 0;
}

static int adc_native_init(const struct device *dev)
{
	struct adc_native_data *const data = dev->data;

	data->dev = dev;
	k_sem_init(&data->idle, 1, 1);
	k_sem_init(&data->done, 0, 1);
	k_timer_init(&data->timer, late, NULL);
	return fault_start(BOARD_CHIP_ADC);
}

static const struct adc_driver_api adc_native_api = {
	.channel_setup = adc_native_channel_setup,
	.read = adc_native_read,
	.read_async = adc_native_read_async,
};

#define ADC_NATIVE_DEFINE(inst)                                                                    \
	static struct adc_native_data adc_native_data_##inst;                                      \
	DEVICE_DT_INST_DEFINE(inst, adc_native_init, NULL, &adc_native_data_##inst, NULL,          \
	                      POST_KERNEL, 40, &adc_native_api);

DT_INST_FOREACH_STATUS_OKAY(ADC_NATIVE_DEFINE)
