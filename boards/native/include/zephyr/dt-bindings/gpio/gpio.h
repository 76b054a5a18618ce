/* SPDX-License-Identifier: Apache-2.0 */
/* GPIO line flags for devicetree and C: Zephyr's names and values. */
#ifndef ZEPHYR_DT_BINDINGS_GPIO_GPIO_H_
#define ZEPHYR_DT_BINDINGS_GPIO_GPIO_H_

#define GPIO_ACTIVE_HIGH 0
#define GPIO_ACTIVE_LOW  1
#define GPIO_PUSH_PULL   0
#define GPIO_PULL_UP     16
#define GPIO_PULL_DOWN   32

#endif
