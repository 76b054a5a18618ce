/* SPDX-License-Identifier: Apache-2.0 */
/* CAN controller of the native board on a bus of the host (compatible "pharos,can-host"): Zephyr's
 * API over can_controller.c. */
#define DT_DRV_COMPAT pharos_can_host

#include <string.h>

#include <zephyr/drivers/can.h>
#include <zephyr/kernel.h>

#include "can_controller.h"
#include "can_host_bus.h"
#include "devices/fault.h"

#define CORE_CLOCK_HZ 80000000u
#define FRAME_FLAGS   (CAN_FRAME_IDE | CAN_FRAME_RTR | CAN_FRAME_FDF | CAN_FRAME_BRS)
#define MODES_FD      (IS_ENABLED(CONFIG_CAN_FD_MODE) ? CAN_MODE_FD : 0)
/* A real controller's modes are set from outside. */
#define MODES_REAL    (CAN_MODE_LOOPBACK | MODES_FD)
#define MODES         (MODES_REAL | CAN_MODE_LISTENONLY | CAN_MODE_ONE_SHOT | CAN_MODE_MANUAL_RECOVERY)

struct can_host_config {
	const char *bus;
	uint32_t bitrate;
	uint32_t bitrate_data;
	uint32_t tx_mailboxes;
};

/* --- set-up ---------------------------------------------------------------------------------- */

static int get_capabilities(const struct device *dev, can_mode_t *cap)
{
	const struct can_controller *controller = dev->data;

	*cap = can_host_bus_is_real(controller->bus) ? MODES_REAL : MODES;
	return 0;
}

static can_mode_t get_mode(const struct device *dev)
{
	const struct can_controller *controller = dev->data;

	return controller->mode;
}

static int set_mode(const struct device *dev, can_mode_t mode)
{
	struct can_controller *controller = dev->data;
	can_mode_t capabilities;

	if (controller->started) {
		return -EBUSY;
	}
	(void)get_capabilities(dev, &capabilities);
	if ((mode & ~capabilities) != 0) {
		return -ENOTSUP;
	}
	controller->mode = mode;
	return 0;
}

static uint32_t rate_of(const struct can_timing *timing)
{
	const uint32_t quanta = 1u + timing->prop_seg + timing->phase_seg1 + timing->phase_seg2;

	return MAX(CORE_CLOCK_HZ / (timing->prescaler * quanta), 1u);
}

static int set_timing(const struct device *dev, const struct can_timing *timing)
{
	struct can_controller *controller = dev->data;

	if (controller->started) {
		return -EBUSY;
	}
	controller->bitrate = rate_of(timing);
	return 0;
}

static int set_timing_data(const struct device *dev, const struct can_timing *timing)
{
	struct can_controller *controller = dev->data;

	if (controller->started) {
		return -EBUSY;
	}
	controller->bitrate_data = rate_of(timing);
	return 0;
}

static int get_core_clock(const struct device *dev, uint32_t *rate)
{
	ARG_UNUSED(dev);
	*rate = CORE_CLOCK_HZ;
	return 0;
}

static int start(const struct device *dev)
{
	struct can_controller *controller = dev->data;

	if (controller->started) {
		return -EALREADY;
	}
	if (fault_start(BOARD_CHIP_CAN) != 0) {
		return -EIO;
	}
	can_controller_start(controller);
	return 0;
}

static int stop(const struct device *dev)
{
	struct can_controller *controller = dev->data;

	if (!controller->started) {
		return -EALREADY;
	}
	can_controller_stop(controller);
	return 0;
}

/* --- frames ---------------------------------------------------------------------------------- */

/* 0, or why nothing can be sent now. */
static int check_sending(const struct can_controller *controller)
{
	if (!controller->started) {
		return -ENETDOWN;
	}
	return controller->state == CAN_STATE_BUS_OFF ? -ENETUNREACH : 0;
}

static bool is_supported(const struct can_controller *controller, uint8_t flags)
{
	const bool fd = (flags & CAN_FRAME_FDF) != 0;

	return (flags & ~FRAME_FLAGS) == 0 && (controller->mode & CAN_MODE_LISTENONLY) == 0 &&
	       !(fd && (controller->mode & CAN_MODE_FD) == 0) &&
	       !(fd && (flags & CAN_FRAME_RTR) != 0) && !(!fd && (flags & CAN_FRAME_BRS) != 0);
}

static int send(const struct device *dev, const struct can_frame *frame, k_timeout_t timeout,
                can_tx_callback_t callback, void *user_data)
{
	struct can_controller *controller = dev->data;
	struct can_host_frame out = {.id = frame->id, .flags = frame->flags};
	int rc;

	if (!is_supported(controller, frame->flags)) {
		return -ENOTSUP;
	}
	rc = check_sending(controller);
	if (rc != 0) {
		return rc;
	}
	if (k_sem_take(&controller->mailboxes_free, timeout) != 0) {
		return -EAGAIN;
	}
	if (fault_of(BOARD_CHIP_CAN)->kind == BOARD_FAULT_NEVER) {
		return 0; /* and the mailbox stays full */
	}
	rc = fault_pass(BOARD_CHIP_CAN);
	if (rc != 0) {
		k_sem_give(&controller->mailboxes_free);
		return rc;
	}
	/* It may have changed meanwhile. */
	rc = check_sending(controller);
	if (rc != 0) {
		k_sem_give(&controller->mailboxes_free);
		return rc;
	}
	out.length = can_dlc_to_bytes(frame->dlc);
	if ((frame->flags & CAN_FRAME_RTR) == 0) {
		memcpy(out.data, frame->data, out.length);
	}
	can_controller_post(controller, &out, callback, user_data);
	return 0;
}

static int add_rx_filter(const struct device *dev, can_rx_callback_t callback, void *user_data,
                         const struct can_filter *filter)
{
	struct can_controller *controller = dev->data;
	int rc = -ENOSPC;
	unsigned int key;

	if ((filter->flags & ~CAN_FILTER_IDE) != 0) {
		return -ENOTSUP;
	}
	key = irq_lock();
	for (int i = 0; i < CAN_CONTROLLER_FILTERS && rc < 0; i++) {
		if (controller->filters[i].callback == NULL) {
			controller->filters[i] = (struct can_controller_filter){
				.callback = callback,
				.user_data = user_data,
				.filter = *filter,
			};
			rc = i;
		}
	}
	irq_unlock(key);
	return rc;
}

static void remove_rx_filter(const struct device *dev, int filter_id)
{
	struct can_controller *controller = dev->data;

	if (filter_id >= 0 && filter_id < CAN_CONTROLLER_FILTERS) {
		controller->filters[filter_id].callback = NULL;
	}
}

static int get_max_filters(const struct device *dev, bool ide)
{
	ARG_UNUSED(dev);
	ARG_UNUSED(ide);
	return CAN_CONTROLLER_FILTERS;
}

/* --- errors ---------------------------------------------------------------------------------- */

static int get_state(const struct device *dev, enum can_state *state,
                     struct can_bus_err_cnt *err_cnt)
{
	const struct can_controller *controller = dev->data;

	if (state != NULL) {
		*state = controller->started ? controller->state : CAN_STATE_STOPPED;
	}
	if (err_cnt != NULL) {
		*err_cnt = can_controller_errors(controller);
	}
	return 0;
}

static void set_state_change_callback(const struct device *dev,
                                      can_state_change_callback_t callback, void *user_data)
{
	struct can_controller *controller = dev->data;
	const unsigned int key = irq_lock();

	controller->state_callback = callback;
	controller->state_user_data = user_data;
	irq_unlock(key);
}

static int recover(const struct device *dev, k_timeout_t timeout)
{
	struct can_controller *controller = dev->data;

	if (!controller->started) {
		return -ENETDOWN;
	}
	if ((controller->mode & CAN_MODE_MANUAL_RECOVERY) == 0) {
		return -ENOTSUP;
	}
	if (controller->state != CAN_STATE_BUS_OFF) {
		return 0;
	}
	k_sem_reset(&controller->recovered);
	if (k_timer_remaining_ticks(&controller->recovery_timer) == 0) {
		can_controller_recover(controller);
	}
	return k_sem_take(&controller->recovered, timeout) == 0 ? 0 : -EAGAIN;
}

static struct can_stats *stats(const struct device *dev)
{
	struct can_controller *controller = dev->data;

	return &controller->stats;
}

/* Ranges of a common CAN FD controller. */
static const struct can_driver_api api = {
	.get_capabilities = get_capabilities,
	.get_mode = get_mode,
	.start = start,
	.stop = stop,
	.set_mode = set_mode,
	.set_timing = set_timing,
	.set_timing_data = set_timing_data,
	.send = send,
	.add_rx_filter = add_rx_filter,
	.remove_rx_filter = remove_rx_filter,
	.recover = recover,
	.get_state = get_state,
	.set_state_change_callback = set_state_change_callback,
	.get_core_clock = get_core_clock,
	.get_max_filters = get_max_filters,
	.stats = stats,
	.min_bitrate = 10000,
	.max_bitrate = 8000000,
	.timing_min = {1, 1, 1, 2, 1},
	.timing_max = {128, 128, 128, 128, 512},
	.timing_data_min = {1, 1, 1, 1, 1},
	.timing_data_max = {16, 16, 16, 16, 32},
};

static int init(const struct device *dev)
{
	const struct can_host_config *config = dev->config;
	struct can_controller *controller = dev->data;
	struct can_bus *bus = can_host_bus_find(config->bus);

	if (bus == NULL || config->bitrate == 0 || config->bitrate_data == 0) {
		return -ENODEV;
	}
	controller->bitrate = config->bitrate;
	controller->bitrate_data = config->bitrate_data;
	controller->mailbox_count = config->tx_mailboxes;
	can_controller_init(controller, dev, bus);
	return 0;
}

#define CAN_HOST_DEFINE(inst)                                                                      \
	static struct can_controller can_controller_##inst;                                        \
	static const struct can_host_config can_host_config_##inst = {                             \
		.bus = DT_INST_PROP(inst, bus),                                                    \
		.bitrate = DT_INST_PROP(inst, bitrate),                                            \
		.bitrate_data = DT_INST_PROP(inst, bitrate_data),                                  \
		.tx_mailboxes = DT_INST_PROP(inst, tx_mailboxes),                                  \
	};                                                                                         \
	_Static_assert(DT_INST_PROP(inst, tx_mailboxes) > 0 &&                                     \
	                       DT_INST_PROP(inst, tx_mailboxes) <= CAN_CONTROLLER_MAILBOXES,       \
	               "tx-mailboxes: 1…32");                                                      \
	DEVICE_DT_INST_DEFINE(inst, init, NULL, &can_controller_##inst, &can_host_config_##inst,   \
	                      POST_KERNEL, CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &api);

DT_INST_FOREACH_STATUS_OKAY(CAN_HOST_DEFINE)
