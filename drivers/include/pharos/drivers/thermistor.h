/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A temperature sensor: an NTC thermistor on an ADC input, oversampled.
 *
 * thermistor_sample(): thread context, one thread; takes a number of conversions. 0: *sample is
 * set, whatever its status. -errno of the ADC: *sample unchanged. -ETIMEDOUT: the ADC has not
 * answered within 100 ms; it is not asked again before the next reset.
 */
#ifndef PHAROS_DRIVERS_THERMISTOR_H_
#define PHAROS_DRIVERS_THERMISTOR_H_

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/sys/util.h>

enum thermistor_status {
	THERMISTOR_OK,
	THERMISTOR_OPEN, /* within 1 % of the upper rail: broken wire, or colder than about -60 degC
	                  */
	THERMISTOR_SHORT, /* within 1 % of the lower rail: short, or hotter than about 220 degC */
};

struct thermistor_sample {
	enum thermistor_status status;
	int32_t temp_mdegc; /* status OK: to 0.5 degC from -40 to +125 degC; else 0 */
	/*
	 * The sum of the conversions, 0…raw_max. Real converters have noise, so that a sum that
	 * stays the same for long is a sign of a stuck sensor. Of a digital sensor, whose value may
	 * stand still: the number of the sample.
	 */
	uint32_t raw;
	uint32_t raw_max;
};

struct thermistor_driver_api {
	int (*sample)(const struct device *dev, struct thermistor_sample *sample);
	bool (*is_simulated)(const struct device *dev); /* NULL: it never is */
};

static inline int thermistor_sample(const struct device *dev, struct thermistor_sample *sample)
{
	return ((const struct thermistor_driver_api *)dev->api)->sample(dev, sample);
}

/* The lamp is real, and what is measured is not its temperature: nothing protects it from heat. Any
 * context.
 */
static inline bool thermistor_is_simulated(const struct device *dev)
{
	const struct thermistor_driver_api *api = (const struct thermistor_driver_api *)dev->api;

	return IS_ENABLED(CONFIG_PHAROS_THERMISTOR_SIMULATED) && api->is_simulated != NULL &&
	       api->is_simulated(dev);
}

#endif
