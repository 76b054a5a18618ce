/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of gpio-pha properties ("gpios", "enable-gpios", …). Included by <zephyr/devicetree.h>. */
#ifndef ZEPHYR_DEVICETREE_GPIO_H_
#define ZEPHYR_DEVICETREE_GPIO_H_

#define DT_GPIO_CTLR_BY_IDX(node_id, pha, idx)  DT_PHANDLE_BY_IDX(node_id, pha, idx)
#define DT_GPIO_CTLR(node_id, pha)              DT_GPIO_CTLR_BY_IDX(node_id, pha, 0)
#define DT_GPIO_PIN_BY_IDX(node_id, pha, idx)   DT_PHA_BY_IDX(node_id, pha, idx, pin)
#define DT_GPIO_PIN(node_id, pha)               DT_GPIO_PIN_BY_IDX(node_id, pha, 0)
#define DT_GPIO_FLAGS_BY_IDX(node_id, pha, idx) DT_PHA_BY_IDX_OR(node_id, pha, idx, flags, 0)
#define DT_GPIO_FLAGS(node_id, pha)             DT_GPIO_FLAGS_BY_IDX(node_id, pha, 0)

#endif
