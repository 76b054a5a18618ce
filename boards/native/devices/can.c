/* SPDX-License-Identifier: Apache-2.0 */
/* What all CAN controllers share: checks of arguments, waiting for a frame, bit timing. */
#include <zephyr/drivers/can.h>

#define BITRATE_MAX         1000000u
#define BITRATE_DATA_MAX    8000000u
#define SAMPLE_OFF_PERMILLE 50
#define SYNC_SEG            1u

struct sent {
	struct k_sem done;
	int error;
};

static void on_sent(const struct device *dev, int error, void *user_data)
{
	struct sent *sent = user_data;

	sent->error = error;
	k_sem_give(&sent->done);
}

static uint32_t id_mask(bool extended)
{
	return extended ? CAN_EXT_ID_MASK : CAN_STD_ID_MASK;
}

int can_send(const struct device *dev, const struct can_frame *frame, k_timeout_t timeout,
             can_tx_callback_t callback, void *user_data)
{
	struct sent sent;
	uint8_t dlc_max;
	int rc;

	if (frame == NULL) {
		return -EINVAL;
	}
	dlc_max = (frame->flags & CAN_FRAME_FDF) != 0 ? CANFD_MAX_DLC : CAN_MAX_DLC;
	if (frame->dlc > dlc_max || frame->id > id_mask((frame->flags & CAN_FRAME_IDE) != 0)) {
		return -EINVAL;
	}
	if (callback != NULL) {
		return CAN_API(dev)->send(dev, frame, timeout, callback, user_data);
	}
	k_sem_init(&sent.done, 0, 1);
	rc = CAN_API(dev)->send(dev, frame, timeout, on_sent, &sent);
	if (rc != 0) {
		return rc;
	}
	k_sem_take(&sent.done, K_FOREVER);
	return sent.error;
}

int can_add_rx_filter(const struct device *dev, can_rx_callback_t callback, void *user_data,
                      const struct can_filter *filter)
{
	uint32_t mask;

	if (callback == NULL || filter == NULL) {
		return -EINVAL;
	}
	mask = id_mask((filter->flags & CAN_FILTER_IDE) != 0);
	if (filter->id > mask || filter->mask > mask) {
		return -EINVAL;
	}
	return CAN_API(dev)->add_rx_filter(dev, callback, user_data, filter);
}

static void put_frame(const struct device *dev, struct can_frame *frame, void *user_data)
{
	if (k_msgq_put(user_data, frame, K_NO_WAIT) != 0) {
		CAN_API(dev)->stats(dev)->rx_overrun++;
	}
}

int can_add_rx_filter_msgq(const struct device *dev, struct k_msgq *msgq,
                           const struct can_filter *filter)
{
	return can_add_rx_filter(dev, put_frame, msgq, filter);
}

/* --- bit timing ----------------------------------------------------------------------------- */

/* CiA 301 has 87.5 % at all rates; the fast ones need more time behind the sample point. */
static uint16_t usual_sample_point(uint32_t bitrate)
{
	if (bitrate > 800000) {
		return 750;
	}
	return bitrate > 500000 ? 800 : 875;
}

/* Splits `quanta` at the sample point as well as the limits allow; how far off it is in permille,
 * or -1. */
static int split(uint32_t quanta, uint16_t sample_point, const struct can_timing *min,
                 const struct can_timing *max, struct can_timing *res)
{
	const uint32_t front_min = min->prop_seg + min->phase_seg1;
	const uint32_t front_max = max->prop_seg + max->phase_seg1;
	uint32_t back = quanta - quanta * sample_point / 1000;
	uint32_t front;
	uint32_t reached;

	back = CLAMP(back, min->phase_seg2, max->phase_seg2);
	if (quanta < SYNC_SEG + front_min + back) {
		back = quanta > SYNC_SEG + front_min ? quanta - SYNC_SEG - front_min : 0;
	} else if (quanta > SYNC_SEG + front_max + back) {
		back = quanta - SYNC_SEG - front_max;
	}
	if (back < min->phase_seg2 || back > max->phase_seg2) {
		return -1;
	}
	front = quanta - SYNC_SEG - back;
	res->prop_seg = (uint16_t)CLAMP(front / 2, min->prop_seg, max->prop_seg);
	res->phase_seg1 = (uint16_t)CLAMP(front - res->prop_seg, min->phase_seg1, max->phase_seg1);
	res->prop_seg = (uint16_t)(front - res->phase_seg1);
	res->phase_seg2 = (uint16_t)back;
	reached = (SYNC_SEG + front) * 1000 / quanta;
	return (int)(reached > sample_point ? reached - sample_point : sample_point - reached);
}

static int calculate(const struct device *dev, const struct can_timing *min,
                     const struct can_timing *max, uint32_t bitrate, uint16_t sample_point,
                     struct can_timing *res)
{
	const uint32_t quanta_max = SYNC_SEG + max->prop_seg + max->phase_seg1 + max->phase_seg2;
	struct can_timing candidate = {0};
	int best = -ENOTSUP;
	uint32_t clock_hz;
	int rc;

	if (bitrate == 0 || sample_point >= 1000) {
		return -EINVAL;
	}
	if (sample_point == 0) {
		sample_point = usual_sample_point(bitrate);
	}
	rc = can_get_core_clock(dev, &clock_hz);
	if (rc != 0) {
		return rc;
	}
	for (uint32_t prescaler = min->prescaler;
	     prescaler <= max->prescaler && prescaler <= clock_hz / bitrate; prescaler++) {
		const uint32_t quanta = clock_hz / prescaler / bitrate;
		int off;

		if (quanta * prescaler * bitrate != clock_hz || quanta > quanta_max) {
			continue;
		}
		off = split(quanta, sample_point, min, max, &candidate);
		if (off >= 0 && (best < 0 || off < best)) {
			best = off;
			candidate.prescaler = (uint16_t)prescaler;
			*res = candidate;
		}
	}
	return best;
}

int can_calc_timing(const struct device *dev, struct can_timing *res, uint32_t bitrate,
                    uint16_t sample_pnt)
{
	if (bitrate > BITRATE_MAX) {
		return -EINVAL;
	}
	return calculate(dev, can_get_timing_min(dev), can_get_timing_max(dev), bitrate, sample_pnt,
	                 res);
}

static bool is_within(uint16_t value, uint16_t min, uint16_t max)
{
	return value >= min && value <= max;
}

/* An sjw of 0 leaves it to the driver. */
static int check(const struct can_timing *timing, const struct can_timing *min,
                 const struct can_timing *max)
{
	return (timing->sjw == 0 || is_within(timing->sjw, min->sjw, max->sjw)) &&
	                       is_within(timing->prop_seg, min->prop_seg, max->prop_seg) &&
	                       is_within(timing->phase_seg1, min->phase_seg1, max->phase_seg1) &&
	                       is_within(timing->phase_seg2, min->phase_seg2, max->phase_seg2) &&
	                       is_within(timing->prescaler, min->prescaler, max->prescaler)
	               ? 0
	               : -ENOTSUP;
}

int can_set_timing(const struct device *dev, const struct can_timing *timing)
{
	const int rc = check(timing, can_get_timing_min(dev), can_get_timing_max(dev));

	return rc != 0 ? rc : CAN_API(dev)->set_timing(dev, timing);
}

static bool has_rate(const struct device *dev, uint32_t bitrate)
{
	return bitrate >= can_get_bitrate_min(dev) && bitrate <= can_get_bitrate_max(dev);
}

int can_set_bitrate(const struct device *dev, uint32_t bitrate)
{
	struct can_timing timing = {0};
	int off;

	if (!has_rate(dev, bitrate)) {
		return -ENOTSUP;
	}
	off = can_calc_timing(dev, &timing, bitrate, 0);
	if (off < 0) {
		return off;
	}
	return off > SAMPLE_OFF_PERMILLE ? -ERANGE : can_set_timing(dev, &timing);
}

#ifdef CONFIG_CAN_FD_MODE
int can_calc_timing_data(const struct device *dev, struct can_timing *res, uint32_t bitrate,
                         uint16_t sample_pnt)
{
	if (bitrate > BITRATE_DATA_MAX) {
		return -EINVAL;
	}
	return calculate(dev, can_get_timing_data_min(dev), can_get_timing_data_max(dev), bitrate,
	                 sample_pnt, res);
}

int can_set_timing_data(const struct device *dev, const struct can_timing *timing_data)
{
	const int rc =
		check(timing_data, can_get_timing_data_min(dev), can_get_timing_data_max(dev));

	return rc != 0 ? rc : CAN_API(dev)->set_timing_data(dev, timing_data);
}

int can_set_bitrate_data(const struct device *dev, uint32_t bitrate_data)
{
	struct can_timing timing = {0};
	int off;

	if (!has_rate(dev, bitrate_data)) {
		return -ENOTSUP;
	}
	off = can_calc_timing_data(dev, &timing, bitrate_data, 0);
	if (off < 0) {
		return off;
	}
	return off > SAMPLE_OFF_PERMILLE ? -ERANGE : can_set_timing_data(dev, &timing);
}
#endif
