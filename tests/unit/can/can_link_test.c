/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a CAN link hears through filters as Zephyr's drivers up to 3.5 have them: a filter takes
 * either classic or FD frames. M_CAN's (STM32's FDCAN) gives a frame to the first filter that its
 * id matches, and drops it when that one is for the other kind; it has eight for extended ids.
 */
#include <zephyr/drivers/can.h>
#include <zephyr/sys/util.h>
#include <zephyr/ztest.h>

static bool first_only;

#define CAN_FILTER_DATA            BIT(2)
#define CAN_FILTER_FDF             BIT(3)
#define PHAROS_CAN_FILTERS_EXCLUDE first_only

#include "threads/can_link.c"

#define SLOTS_MAX 16

static struct slot {
	can_rx_callback_t callback;
	struct can_filter filter;
} slots[SLOTS_MAX];
static int slot_count; /* the controller's */
static struct can_stats counters;

/* --- a controller ----------------------------------------------------------------------------- */

static int fake_capabilities(const struct device *dev, can_mode_t *cap)
{
	*cap = CAN_MODE_FD;
	return 0;
}

static int fake_set_mode(const struct device *dev, can_mode_t mode)
{
	return 0;
}

static int fake_start(const struct device *dev)
{
	return 0;
}

static int fake_set_timing(const struct device *dev, const struct can_timing *timing)
{
	return 0;
}

static int fake_add(const struct device *dev, can_rx_callback_t callback, void *user_data,
                    const struct can_filter *filter)
{
	for (int i = 0; i < slot_count; i++) {
		if (slots[i].callback == NULL) {
			slots[i] = (struct slot){callback, *filter};
			return i;
		}
	}
	return -ENOSPC;
}

static void fake_remove(const struct device *dev, int id)
{
	slots[id] = (struct slot){0};
}

static int fake_state(const struct device *dev, enum can_state *state,
                      struct can_bus_err_cnt *errors)
{
	*state = CAN_STATE_ERROR_ACTIVE;
	*errors = (struct can_bus_err_cnt){0};
	return 0;
}

static void fake_on_state(const struct device *dev, can_state_change_callback_t callback,
                          void *user_data)
{
}

static int fake_clock(const struct device *dev, uint32_t *rate)
{
	*rate = 80000000;
	return 0;
}

static struct can_stats *fake_stats(const struct device *dev)
{
	return &counters;
}

static const struct can_driver_api fake_api = {
	.get_capabilities = fake_capabilities,
	.start = fake_start,
	.set_mode = fake_set_mode,
	.set_timing = fake_set_timing,
	.set_timing_data = fake_set_timing,
	.add_rx_filter = fake_add,
	.remove_rx_filter = fake_remove,
	.get_state = fake_state,
	.set_state_change_callback = fake_on_state,
	.get_core_clock = fake_clock,
	.stats = fake_stats,
	.max_bitrate = 8000000,
	.timing_min = {1, 1, 1, 1, 1},
	.timing_max = {128, 0, 256, 128, 512},
};

static int fake_init(const struct device *dev)
{
	return 0;
}

DEVICE_DEFINE(fake_can, "fake_can", fake_init, NULL, NULL, NULL, POST_KERNEL, 50, &fake_api);

/* --- what the link stands on ------------------------------------------------------------------ */

const struct devices devices = {.can_link = DEVICE_GET(fake_can)};

void inbox_post_can(const struct dronecan_frame *frame, enum supervisor_watch watch)
{
}

void inbox_wake(void)
{
}

void supervisor_report(enum supervisor_watch watch)
{
}

int startup_result(enum startup_step step)
{
	return 0;
}

void startup_done(enum startup_step step, int result)
{
}

/* --- tests ------------------------------------------------------------------------------------ */

static bool fits(const struct can_filter *filter, const struct can_frame *frame)
{
	return ((filter->id ^ frame->id) & filter->mask) == 0;
}

/* Whether the link hears a frame of that id. */
static bool hears(uint32_t id, bool fd)
{
	struct can_frame frame = {.id = id, .flags = CAN_FRAME_IDE | (fd ? CAN_FRAME_FDF : 0)};
	const uint32_t before = can_link_status_get().stats.rx_frames;

	for (int i = 0; i < slot_count; i++) {
		if (slots[i].callback == NULL || !fits(&slots[i].filter, &frame)) {
			continue;
		}
		if (((slots[i].filter.flags & CAN_FILTER_FDF) != 0) == fd) {
			slots[i].callback(devices.can_link, &frame, NULL);
			break;
		}
		if (first_only) {
			break;
		}
	}
	k_msgq_purge(&received);
	return can_link_status_get().stats.rx_frames == before + 1;
}

/* Five, as a node of id 42 with a light, a hardpoint and actuators has. DroneCAN 3001, 1081, 1070,
 * 1010: message types; services to it have bit 7. */
static const struct can_link_filter five[] = {
	{.id = 3001u << 8, .mask = 0xFFFF80}, {.id = 42u << 8 | 0x80, .mask = 0x7F80},
	{.id = 1081u << 8, .mask = 0xFFFF80}, {.id = 1070u << 8, .mask = 0xFFFF80},
	{.id = 1010u << 8, .mask = 0xFFFF80},
};

static void listen(bool driver_takes_first, int filters, bool fd)
{
	first_only = driver_takes_first;
	slot_count = filters;
	zassert_equal(can_link_init(1000000, fd), 0);
	can_link_listen(five, ARRAY_SIZE(five));
}

static void after(void *fixture)
{
	can_link_listen(NULL, 0);
}

ZTEST(can_link, test_fd_bus_on_fdcan)
{
	listen(true, 8, true);
	for (size_t i = 0; i < ARRAY_SIZE(five); i++) {
		zassert_true(hears(five[i].id | 10, true), "%zu", i);
	}
	zassert_false(hears(1011u << 8 | 10, true), "not for this light");
}

ZTEST(can_link, test_classic_bus_on_fdcan)
{
	listen(true, 8, false);
	for (size_t i = 0; i < ARRAY_SIZE(five); i++) {
		zassert_true(hears(five[i].id | 10, false), "%zu", i);
	}
	zassert_false(hears(1011u << 8 | 10, false), "not for this light");
}

ZTEST(can_link, test_both_kinds_where_filters_are_compared_one_by_one)
{
	listen(false, 16, true);
	for (size_t i = 0; i < ARRAY_SIZE(five); i++) {
		zassert_true(hears(five[i].id | 10, false), "%zu", i);
		zassert_true(hears(five[i].id | 10, true), "%zu", i);
	}
	zassert_false(hears(1011u << 8 | 10, true), "not for this light");
}

ZTEST(can_link, test_too_few_filters_take_everything)
{
	listen(true, 4, true);
	zassert_true(hears(five[4].id | 10, true));
	zassert_true(hears(1011u << 8 | 10, true));
}

ZTEST_SUITE(can_link, NULL, NULL, NULL, after, NULL);
