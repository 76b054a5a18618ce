/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/can_link.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/atomic.h>

#include <pharos/compat.h>

#include "threads/devices.h"
#include "threads/inbox.h"
#include "threads/limits.h"
#include "threads/startup.h"
#include "threads/supervisor.h"

LOG_MODULE_REGISTER(can_link);

CAN_MSGQ_DEFINE(received, CONFIG_PHAROS_CAN_RX_FRAMES);

static struct can_link_stats stats;
static int filter_ids[2 * CAN_LINK_FILTERS_MAX];
static size_t filter_count;
static bool opened;
static bool has_fd;
/* The command thread waits for a mailbox, or for the bus; whoever clears it wakes the thread. */
static atomic_t blocked;

/* --- interrupt -------------------------------------------------------------------------------- */

static void unblock(void)
{
	if (atomic_set(&blocked, 0) != 0) {
		inbox_wake();
	}
}

static void on_frame(const struct device *can, struct can_frame *frame, void *user_data)
{
	if (k_msgq_put(&received, frame, K_NO_WAIT) == 0) {
		stats.rx_frames++;
	} else {
		stats.rx_overruns++;
	}
}

static void on_sent(const struct device *can, int error, void *user_data)
{
	if (error == 0) {
		stats.tx_frames++;
	} else {
		stats.tx_failed++;
	}
	unblock();
}

static void on_state(const struct device *can, enum can_state state, struct can_bus_err_cnt errors,
                     void *user_data)
{
	if (state == CAN_STATE_BUS_OFF) {
		stats.bus_offs++;
	} else {
		unblock();
	}
}

/* --- set-up ----------------------------------------------------------------------------------- */

static bool set_fd(void)
{
	can_mode_t modes = 0;

	return can_get_capabilities(devices.can_link, &modes) == 0 && (modes & CAN_MODE_FD) != 0 &&
	       can_set_mode(devices.can_link, CAN_MODE_FD) == 0;
}

int can_link_init(uint32_t bitrate, bool fd)
{
	int error;

	if (startup_result(STARTUP_CAN_LINK) != 0) {
		return -ENODEV;
	}
	has_fd = fd && set_fd();
	if (fd && !has_fd) {
		LOG_WRN("this controller has no CAN FD; classic frames");
	}
	error = can_set_bitrate(devices.can_link, bitrate);
	if (error != 0) {
		LOG_WRN("bit rate %u: error %d; the devicetree's stays", bitrate, error);
	}
	can_set_state_change_callback(devices.can_link, on_state, NULL);
	error = can_start(devices.can_link);
	startup_done(STARTUP_CAN_LINK, error);
	if (error != 0) {
		return error;
	}
	opened = true;
	return 0;
}

bool can_link_has_fd(void)
{
	return has_fd;
}

static bool add_kind(const struct can_link_filter *wanted, uint8_t flags)
{
	const struct can_filter filter = {
		.id = wanted->id,
		.mask = wanted->mask,
		.flags = CAN_FILTER_IDE | CAN_FILTER_DATA | flags,
	};
	const int id = can_add_rx_filter(devices.can_link, on_frame, NULL, &filter);

	if (id < 0) {
		return false;
	}
	filter_ids[filter_count++] = id;
	return true;
}

/*
 * Where filters tell the kinds of frames apart, FD frames have filters of their own; where one can
 * have but one kind, a bus with FD on carries FD frames.
 */
static bool add_filter(const struct can_link_filter *wanted)
{
	const bool fd = CAN_FILTER_FDF != 0 && has_fd;

	return ((fd && PHAROS_CAN_FILTERS_EXCLUDE) || add_kind(wanted, 0)) &&
	       (!fd || add_kind(wanted, CAN_FILTER_FDF));
}

static void remove_filters(void)
{
	while (filter_count > 0) {
		can_remove_rx_filter(devices.can_link, filter_ids[--filter_count]);
	}
}

void can_link_listen(const struct can_link_filter *filters, size_t count)
{
	static const struct can_link_filter everything;

	remove_filters();
	for (size_t i = 0; i < count; i++) {
		if (!add_filter(&filters[i])) {
			remove_filters();
			if (!add_filter(&everything)) {
				LOG_ERR("no filter: the light does not hear the bus");
			}
			return;
		}
	}
}

/* --- sending ---------------------------------------------------------------------------------- */

static int send_now(const struct dronecan_frame *frame)
{
	struct can_frame out = {
		.id = frame->id,
		.dlc = can_bytes_to_dlc(frame->size),
		.flags = CAN_FRAME_IDE,
	};

	if (frame->fd) {
		out.flags |= CAN_FRAME_FDF | CAN_FRAME_BRS;
	}
	memcpy(out.data, frame->data, MIN(frame->size, sizeof(out.data)));
	return can_send(devices.can_link, &out, K_NO_WAIT, on_sent, NULL);
}

bool can_link_send(const struct dronecan_frame *frame)
{
	int error;

	if (!opened || atomic_get(&blocked) != 0) {
		return false;
	}
	error = send_now(frame);
	if (error == -EAGAIN || error == -ENETUNREACH || error == -ENETDOWN) {
		/* what frees a mailbox before this is not told; so a second try after it */
		atomic_set(&blocked, 1);
		stats.tx_waits++;
		error = send_now(frame);
		if (error == -EAGAIN || error == -ENETUNREACH || error == -ENETDOWN) {
			return false;
		}
		atomic_set(&blocked, 0);
	}
	if (error != 0) {
		stats.tx_failed++;
	}
	return true;
}

/* --- status ----------------------------------------------------------------------------------- */

static uint32_t bus_errors(void)
{
#ifdef CONFIG_CAN_STATS
	return can_stats_get_bit_errors(devices.can_link) +
	       can_stats_get_stuff_errors(devices.can_link) +
	       can_stats_get_crc_errors(devices.can_link) +
	       can_stats_get_form_errors(devices.can_link) +
	       can_stats_get_ack_errors(devices.can_link);
#else
	return 0;
#endif
}

struct can_link_status can_link_status_get(void)
{
	struct can_link_status status = {.state = CAN_STATE_STOPPED};
	const unsigned int key = irq_lock();

	status.stats = stats;
	irq_unlock(key);
	if (opened) {
		status.stats.bus_errors = bus_errors();
		(void)can_get_state(devices.can_link, &status.state, &status.errors);
	}
	return status;
}

/* --- thread ----------------------------------------------------------------------------------- */

/* To the command thread, which takes it before this one goes on; waits while it is behind. */
static void post(const struct can_frame *from)
{
	struct dronecan_frame frame = {
		.id = from->id,
		.fd = (from->flags & CAN_FRAME_FDF) != 0,
		.size = MIN(can_dlc_to_bytes(from->dlc), sizeof(from->data)),
	};

	memcpy(frame.data, from->data, frame.size);
	inbox_post_can(&frame, SUPERVISOR_CAN_LINK);
}

void can_link_run(void *p1, void *p2, void *p3)
{
	for (;;) {
		struct can_frame frame;

		supervisor_report(SUPERVISOR_CAN_LINK);
		if (k_msgq_get(&received, &frame, K_MSEC(SUPERVISOR_REPORT_MS)) == 0 &&
		    (frame.flags & CAN_FRAME_RTR) == 0) {
			post(&frame);
		}
	}
}
