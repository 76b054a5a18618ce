/* SPDX-License-Identifier: Apache-2.0 */
/* ADC constants for devicetree and C: acquisition time as <unit, 14-bit value>. */
#ifndef ZEPHYR_DT_BINDINGS_ADC_ADC_H_
#define ZEPHYR_DT_BINDINGS_ADC_ADC_H_

#define ADC_ACQ_TIME_MICROSECONDS 1
#define ADC_ACQ_TIME_NANOSECONDS  2
#define ADC_ACQ_TIME_TICKS        3
#define ADC_ACQ_TIME(unit, value) (((unit) << 14) | ((value)&0x3FFF))
#define ADC_ACQ_TIME_DEFAULT      0

#endif
