/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of "io-channels" properties. Included by <zephyr/devicetree.h>. */
#ifndef ZEPHYR_DEVICETREE_IO_CHANNELS_H_
#define ZEPHYR_DEVICETREE_IO_CHANNELS_H_

#define DT_IO_CHANNELS_CTLR_BY_IDX(node_id, idx)  DT_PHANDLE_BY_IDX(node_id, io_channels, idx)
#define DT_IO_CHANNELS_CTLR(node_id)              DT_IO_CHANNELS_CTLR_BY_IDX(node_id, 0)
#define DT_IO_CHANNELS_INPUT_BY_IDX(node_id, idx) DT_PHA_BY_IDX(node_id, io_channels, idx, input)
#define DT_IO_CHANNELS_INPUT(node_id)             DT_IO_CHANNELS_INPUT_BY_IDX(node_id, 0)

#endif
