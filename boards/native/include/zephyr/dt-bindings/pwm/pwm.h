/* SPDX-License-Identifier: Apache-2.0 */
/* PWM constants for devicetree and C. Periods are in nanoseconds. */
#ifndef ZEPHYR_DT_BINDINGS_PWM_PWM_H_
#define ZEPHYR_DT_BINDINGS_PWM_PWM_H_

#define PWM_NSEC(x) (x)
#define PWM_USEC(x) ((x)*1000)
#define PWM_MSEC(x) ((x)*1000000)
#define PWM_HZ(x)   (1000000000 / (x))
#define PWM_KHZ(x)  (1000000 / (x))

#define PWM_POLARITY_NORMAL   0
#define PWM_POLARITY_INVERTED 1

#endif
