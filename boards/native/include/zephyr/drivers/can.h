/* SPDX-License-Identifier: Apache-2.0 */
/*
 * CAN controllers, by Zephyr's names and with the semantics of its newer versions (3.7 and on).
 * What differs before: filters need CAN_FILTER_DATA up to 3.5, and can_get_bitrate_max() is called
 * can_get_max_bitrate() up to 3.6; an app that serves all has its own header of fallbacks.
 *
 *   can_set_mode(dev, CAN_MODE_FD); can_set_bitrate(dev, 1000000);   while stopped
 *   can_add_rx_filter(dev, on_frame, arg, &filter);                  at any time
 *   can_start(dev);
 *   can_send(dev, &frame, K_MSEC(10), on_sent, arg);
 *
 * Callbacks run in interrupt context. Errors are negative errno values.
 */
#ifndef ZEPHYR_DRIVERS_CAN_H_
#define ZEPHYR_DRIVERS_CAN_H_

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/util.h>

#define CAN_STD_ID_MASK 0x7FFU
#define CAN_EXT_ID_MASK 0x1FFFFFFFU
#define CAN_MAX_STD_ID  CAN_STD_ID_MASK
#define CAN_MAX_EXT_ID  CAN_EXT_ID_MASK
#define CAN_MAX_DLC     8U
#define CANFD_MAX_DLC   15U
#ifdef CONFIG_CAN_FD_MODE
#define CAN_MAX_DLEN 64U
#else
#define CAN_MAX_DLEN 8U
#endif

typedef uint32_t can_mode_t;

#define CAN_MODE_NORMAL          0
#define CAN_MODE_LOOPBACK        BIT(0) /* receives its own frames, and nobody else's */
#define CAN_MODE_LISTENONLY      BIT(1) /* never sends a dominant bit: can_send() is -ENOTSUP */
#define CAN_MODE_FD              BIT(2) /* sends and receives CAN FD frames as well */
#define CAN_MODE_ONE_SHOT        BIT(3) /* no retransmission */
#define CAN_MODE_3_SAMPLES       BIT(4)
#define CAN_MODE_MANUAL_RECOVERY BIT(5) /* bus-off lasts until can_recover() */

enum can_state {
	CAN_STATE_ERROR_ACTIVE,
	CAN_STATE_ERROR_WARNING, /* an error counter is 96 or more */
	CAN_STATE_ERROR_PASSIVE, /* … 128 or more */
	CAN_STATE_BUS_OFF,       /* the counter of transmit errors is 256 or more */
	CAN_STATE_STOPPED,
};

#define CAN_FRAME_IDE BIT(0) /* extended (29-bit) id */
#define CAN_FRAME_RTR BIT(1) /* remote transmission request */
#define CAN_FRAME_FDF BIT(2) /* CAN FD */
#define CAN_FRAME_BRS BIT(3) /* CAN FD: data at the data phase's bit rate */
#define CAN_FRAME_ESI BIT(4) /* CAN FD: its sender is error-passive; received frames only */

struct can_frame {
	uint32_t id;
	uint8_t dlc;   /* a length code: can_dlc_to_bytes() */
	uint8_t flags; /* CAN_FRAME_… */
	uint16_t res;
	union {
		uint8_t data[CAN_MAX_DLEN];
		uint32_t data_32[DIV_ROUND_UP(CAN_MAX_DLEN, sizeof(uint32_t))];
	};
};

#define CAN_FILTER_IDE BIT(0) /* matches extended ids; without it: standard ids */

/* A frame matches if its id equals `id` in the bits that are set in `mask`. */
struct can_filter {
	uint32_t id;
	uint32_t mask;
	uint8_t flags; /* CAN_FILTER_… */
};

struct can_bus_err_cnt {
	uint8_t tx_err_cnt; /* 255: that, or more */
	uint8_t rx_err_cnt;
};

/*
 * A bit is 1 + prop_seg + phase_seg1 + phase_seg2 time quanta of prescaler / core clock each; it is
 * sampled before phase_seg2.
 */
struct can_timing {
	uint16_t sjw;
	uint16_t prop_seg;
	uint16_t phase_seg1;
	uint16_t phase_seg2;
	uint16_t prescaler;
};

/* error: 0, or what can_send() returns when it waits itself. */
typedef void (*can_tx_callback_t)(const struct device *dev, int error, void *user_data);
typedef void (*can_rx_callback_t)(const struct device *dev, struct can_frame *frame,
                                  void *user_data);
typedef void (*can_state_change_callback_t)(const struct device *dev, enum can_state state,
                                            struct can_bus_err_cnt err_cnt, void *user_data);

/* Counters of a device, for its driver. */
struct can_stats {
	uint32_t bit0_error; /* no dominant bit although one was sent */
	uint32_t bit1_error; /* no recessive bit although one was sent */
	uint32_t stuff_error;
	uint32_t crc_error;
	uint32_t form_error;
	uint32_t ack_error;
	uint32_t rx_overrun;
};

/* A driver's functions; the calls below check their arguments first. */
struct can_driver_api {
	int (*get_capabilities)(const struct device *dev, can_mode_t *cap);
	can_mode_t (*get_mode)(const struct device *dev);
	int (*start)(const struct device *dev);
	int (*stop)(const struct device *dev);
	int (*set_mode)(const struct device *dev, can_mode_t mode);
	int (*set_timing)(const struct device *dev, const struct can_timing *timing);
	int (*set_timing_data)(const struct device *dev, const struct can_timing *timing);
	int (*send)(const struct device *dev, const struct can_frame *frame, k_timeout_t timeout,
	            can_tx_callback_t callback, void *user_data);
	int (*add_rx_filter)(const struct device *dev, can_rx_callback_t callback, void *user_data,
	                     const struct can_filter *filter);
	void (*remove_rx_filter)(const struct device *dev, int filter_id);
	int (*recover)(const struct device *dev, k_timeout_t timeout);
	int (*get_state)(const struct device *dev, enum can_state *state,
	                 struct can_bus_err_cnt *err_cnt);
	void (*set_state_change_callback)(const struct device *dev,
	                                  can_state_change_callback_t callback, void *user_data);
	int (*get_core_clock)(const struct device *dev, uint32_t *rate);
	int (*get_max_filters)(const struct device *dev, bool ide);
	struct can_stats *(*stats)(const struct device *dev);
	uint32_t min_bitrate;
	uint32_t max_bitrate;
	struct can_timing timing_min;
	struct can_timing timing_max;
	struct can_timing timing_data_min;
	struct can_timing timing_data_max;
};

#define CAN_API(dev) ((const struct can_driver_api *)(dev)->api)

/* --- frames: any context -------------------------------------------------------------------- */

static inline uint8_t can_dlc_to_bytes(uint8_t dlc)
{
	static const uint8_t bytes[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

	return bytes[MIN(dlc, CANFD_MAX_DLC)];
}

/* The shortest code that holds so many bytes. */
static inline uint8_t can_bytes_to_dlc(uint8_t num_bytes)
{
	uint8_t dlc = MIN(num_bytes, CAN_MAX_DLC);

	while (dlc < CANFD_MAX_DLC && can_dlc_to_bytes(dlc) < num_bytes) {
		dlc++;
	}
	return dlc;
}

static inline bool can_frame_matches_filter(const struct can_frame *frame,
                                            const struct can_filter *filter)
{
	const bool frame_ide = (frame->flags & CAN_FRAME_IDE) != 0;
	const bool filter_ide = (filter->flags & CAN_FILTER_IDE) != 0;

	return frame_ide == filter_ide && ((frame->id ^ filter->id) & filter->mask) == 0;
}

/* --- set-up: threads; all but the getters while the controller is stopped (else -EBUSY) --------
 */

/* CAN_MODE_… that can be set, in any combination. */
static inline int can_get_capabilities(const struct device *dev, can_mode_t *cap)
{
	return CAN_API(dev)->get_capabilities(dev, cap);
}

static inline can_mode_t can_get_mode(const struct device *dev)
{
	return CAN_API(dev)->get_mode(dev);
}

/* -ENOTSUP: not among the capabilities; the mode stays as it was. */
static inline int can_set_mode(const struct device *dev, can_mode_t mode)
{
	return CAN_API(dev)->set_mode(dev, mode);
}

/* In Hz: what prescalers divide. */
static inline int can_get_core_clock(const struct device *dev, uint32_t *rate)
{
	return CAN_API(dev)->get_core_clock(dev, rate);
}

static inline uint32_t can_get_bitrate_min(const struct device *dev)
{
	return CAN_API(dev)->min_bitrate;
}

static inline uint32_t can_get_bitrate_max(const struct device *dev)
{
	return CAN_API(dev)->max_bitrate;
}

static inline const struct can_timing *can_get_timing_min(const struct device *dev)
{
	return &CAN_API(dev)->timing_min;
}

static inline const struct can_timing *can_get_timing_max(const struct device *dev)
{
	return &CAN_API(dev)->timing_max;
}

/*
 * The timing for a bit rate and a sample point in permille (0: the usual one). How far off the
 * sample point is, in permille; -EINVAL: out of range; -ENOTSUP: the clock cannot make this rate.
 */
int can_calc_timing(const struct device *dev, struct can_timing *res, uint32_t bitrate,
                    uint16_t sample_pnt);

/* -ENOTSUP: out of the controller's range. */
int can_set_timing(const struct device *dev, const struct can_timing *timing);

/* -ENOTSUP: not within the controller's rates, or its clock cannot make this one; -EINVAL: more
 * than 1 Mbit/s (data phase: 8 Mbit/s); -ERANGE: the sample point would be off by more than 5 %. */
int can_set_bitrate(const struct device *dev, uint32_t bitrate);

#ifdef CONFIG_CAN_FD_MODE
/* The same for the data phase. */
static inline const struct can_timing *can_get_timing_data_min(const struct device *dev)
{
	return &CAN_API(dev)->timing_data_min;
}

static inline const struct can_timing *can_get_timing_data_max(const struct device *dev)
{
	return &CAN_API(dev)->timing_data_max;
}

int can_calc_timing_data(const struct device *dev, struct can_timing *res, uint32_t bitrate,
                         uint16_t sample_pnt);
int can_set_timing_data(const struct device *dev, const struct can_timing *timing_data);
int can_set_bitrate_data(const struct device *dev, uint32_t bitrate_data);
#endif

/* Joins the bus. -EALREADY: it is started. Error counters begin at 0. */
static inline int can_start(const struct device *dev)
{
	return CAN_API(dev)->start(dev);
}

/* Leaves it: frames that wait end with -ENETDOWN. -EALREADY: it is stopped. */
static inline int can_stop(const struct device *dev)
{
	return CAN_API(dev)->stop(dev);
}

/* --- sending ------------------------------------------------------------------------------- */

/*
 * Puts a frame into a transmit mailbox; waits for a free one at most `timeout` (-EAGAIN). Mailboxes
 * are sent in the order of their frames' priorities. With a callback: returns 0 then, and calls it
 * when the frame was sent or given up. callback == NULL: waits for that (threads only). Any context
 * with a callback and K_NO_WAIT.
 *
 * -EINVAL: no such id or length; -ENOTSUP: a kind of frame that the mode does not have; -ENETDOWN:
 * stopped; -ENETUNREACH: bus-off. One-shot mode only: -EBUSY: lost arbitration; -EIO: error or no
 * acknowledgement.
 */
int can_send(const struct device *dev, const struct can_frame *frame, k_timeout_t timeout,
             can_tx_callback_t callback, void *user_data);

/* --- receiving ----------------------------------------------------------------------------- */

/*
 * Calls `callback` for each frame that matches; a frame that matches several filters comes to all
 * of them. The number of the filter; -ENOSPC: all are used; -EINVAL: no such id or mask; -ENOTSUP:
 * flags. Any context.
 */
int can_add_rx_filter(const struct device *dev, can_rx_callback_t callback, void *user_data,
                      const struct can_filter *filter);

/* The same into a message queue of struct can_frame; a full one loses frames (rx_overruns). */
int can_add_rx_filter_msgq(const struct device *dev, struct k_msgq *msgq,
                           const struct can_filter *filter);

#define CAN_MSGQ_DEFINE(name, max_frames)                                                          \
	K_MSGQ_DEFINE(name, sizeof(struct can_frame), max_frames, 4)

static inline void can_remove_rx_filter(const struct device *dev, int filter_id)
{
	CAN_API(dev)->remove_rx_filter(dev, filter_id);
}

/* How many there are, of standard or of extended ids. */
static inline int can_get_max_filters(const struct device *dev, bool ide)
{
	return CAN_API(dev)->get_max_filters(dev, ide);
}

/* --- errors -------------------------------------------------------------------------------- */

/* Either pointer may be NULL. Any context. */
static inline int can_get_state(const struct device *dev, enum can_state *state,
                                struct can_bus_err_cnt *err_cnt)
{
	return CAN_API(dev)->get_state(dev, state, err_cnt);
}

/* One per controller; NULL: none. */
static inline void can_set_state_change_callback(const struct device *dev,
                                                 can_state_change_callback_t callback,
                                                 void *user_data)
{
	CAN_API(dev)->set_state_change_callback(dev, callback, user_data);
}

/*
 * Manual recovery mode: begins to recover from bus-off, waits until it has. 0 at once when it is
 * not bus-off. -ENOTSUP: recovery is automatic; -ENETDOWN: stopped; -EAGAIN: not yet. Threads.
 */
static inline int can_recover(const struct device *dev, k_timeout_t timeout)
{
	return CAN_API(dev)->recover(dev, timeout);
}

#ifdef CONFIG_CAN_STATS
static inline uint32_t can_stats_get_bit0_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->bit0_error;
}

static inline uint32_t can_stats_get_bit1_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->bit1_error;
}

static inline uint32_t can_stats_get_bit_errors(const struct device *dev)
{
	return can_stats_get_bit0_errors(dev) + can_stats_get_bit1_errors(dev);
}

static inline uint32_t can_stats_get_stuff_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->stuff_error;
}

static inline uint32_t can_stats_get_crc_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->crc_error;
}

static inline uint32_t can_stats_get_form_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->form_error;
}

static inline uint32_t can_stats_get_ack_errors(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->ack_error;
}

static inline uint32_t can_stats_get_rx_overruns(const struct device *dev)
{
	return CAN_API(dev)->stats(dev)->rx_overrun;
}
#endif

#endif
