/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of "pwms" properties; the period is in nanoseconds. Included by <zephyr/devicetree.h>. */
#ifndef ZEPHYR_DEVICETREE_PWMS_H_
#define ZEPHYR_DEVICETREE_PWMS_H_

#define DT_PWMS_CTLR_BY_IDX(node_id, idx)    DT_PHANDLE_BY_IDX(node_id, pwms, idx)
#define DT_PWMS_CTLR(node_id)                DT_PWMS_CTLR_BY_IDX(node_id, 0)
#define DT_PWMS_CHANNEL_BY_IDX(node_id, idx) DT_PHA_BY_IDX(node_id, pwms, idx, channel)
#define DT_PWMS_CHANNEL(node_id)             DT_PWMS_CHANNEL_BY_IDX(node_id, 0)
#define DT_PWMS_PERIOD_BY_IDX(node_id, idx)  DT_PHA_BY_IDX_OR(node_id, pwms, idx, period, 0)
#define DT_PWMS_PERIOD(node_id)              DT_PWMS_PERIOD_BY_IDX(node_id, 0)
#define DT_PWMS_FLAGS_BY_IDX(node_id, idx)   DT_PHA_BY_IDX_OR(node_id, pwms, idx, flags, 0)
#define DT_PWMS_FLAGS(node_id)               DT_PWMS_FLAGS_BY_IDX(node_id, 0)

#define DT_INST_PWMS_PERIOD(inst) DT_PWMS_PERIOD(DT_DRV_INST(inst))

#endif
