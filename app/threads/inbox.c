/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/inbox.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>

#include <pharos/compat.h>

#include "threads/clock.h"
#include "threads/frames.h"
#include "threads/limits.h"

#define START_WAIT_MS 1500
#define START_POLL_MS 10

/* On its caller's stack. */
struct inbox_call {
	int (*function)(struct pharos_device *device, void *argument);
	void *argument;
	int result;
	struct k_sem done;
};

K_MSGQ_DEFINE(queue, sizeof(struct inbox_item), COMMAND_QUEUE_MAX, 8);
K_MEM_SLAB_DEFINE_STATIC(frames, ROUND_UP(sizeof(struct link_frame), 8), LINK_FRAMES_MAX, 8);
#ifdef CONFIG_CAN
K_MEM_SLAB_DEFINE_STATIC(can_frames, ROUND_UP(sizeof(struct dronecan_frame), 8), CAN_FRAMES_MAX, 8);
#endif
#ifdef CONFIG_PHAROS_IMC
K_MEM_SLAB_DEFINE_STATIC(imc_frames, ROUND_UP(sizeof(struct imc_frame), 8), IMC_FRAMES_MAX, 8);
#endif

static struct inbox_stats stats;
static atomic_t is_open;

/* --- link threads ----------------------------------------------------------------------------- */

static void *buffer_of(struct k_mem_slab *pool, enum supervisor_watch watch)
{
	void *block;

	while (k_mem_slab_alloc(pool, &block, K_MSEC(SUPERVISOR_REPORT_MS)) != 0) {
		supervisor_report(watch);
	}
	return block;
}

static void post(const struct inbox_item *item, enum supervisor_watch watch)
{
	while (k_msgq_put(&queue, item, K_MSEC(SUPERVISOR_REPORT_MS)) != 0) {
		supervisor_report(watch);
	}
}

void inbox_post_frame(uint8_t link, const uint8_t *bytes, size_t length,
                      enum supervisor_watch watch)
{
	struct link_frame *const frame = buffer_of(&frames, watch);
	const struct inbox_item item = {.kind = INBOX_FRAME, .frame = frame};

	frame->link = link;
	frame->length = (uint16_t)length;
	memcpy(frame->bytes, bytes, length);
	post(&item, watch);
}

#ifdef CONFIG_CAN
void inbox_post_can(const struct dronecan_frame *received, enum supervisor_watch watch)
{
	struct dronecan_frame *const frame = buffer_of(&can_frames, watch);
	const struct inbox_item item = {.kind = INBOX_CAN, .can = frame};

	*frame = *received;
	post(&item, watch);
}
#endif

#ifdef CONFIG_PHAROS_IMC
void inbox_post_imc(const struct imc_route *route, const uint8_t *bytes, size_t length,
                    enum supervisor_watch watch)
{
	struct imc_frame *const frame = buffer_of(&imc_frames, watch);
	const struct inbox_item item = {.kind = INBOX_IMC, .imc = frame};

	frame->route = *route;
	frame->length = (uint16_t)length;
	memcpy(frame->bytes, bytes, length);
	post(&item, watch);
}
#endif

/* --- anyone ----------------------------------------------------------------------------------- */

/* With a full queue it is awake, and looks after the next item. */
void inbox_wake(void)
{
	const struct inbox_item item = {.kind = INBOX_WAKE};

	(void)k_msgq_put(&queue, &item, K_NO_WAIT);
}

void inbox_post_thermal(const struct thermal_report *report)
{
	const struct inbox_item item = {.kind = INBOX_THERMAL, .thermal = *report};

	if (k_msgq_put(&queue, &item, K_NO_WAIT) != 0) {
		stats.reports_dropped++;
	}
}

int inbox_call(int (*function)(struct pharos_device *, void *), void *argument)
{
	struct inbox_call call = {.function = function, .argument = argument};
	const struct inbox_item item = {.kind = INBOX_CALL, .call = &call};

	for (int waited_ms = 0; atomic_get(&is_open) == 0; waited_ms += START_POLL_MS) {
		/* start-up ends or is bitten, but for a watchdog that does not answer either */
		if (supervisor_age_ms(SUPERVISOR_START) < 0 || waited_ms >= START_WAIT_MS) {
			return -EAGAIN;
		}
		k_sleep(K_MSEC(START_POLL_MS));
	}
	k_sem_init(&call.done, 0, 1);
	/* K_FOREVER: the supervisor watches who answers; a call cannot be taken back */
	k_msgq_put(&queue, &item, K_FOREVER);
	k_sem_take(&call.done, K_FOREVER); /* the same */
	return call.result;
}

struct inbox_stats inbox_stats_get(void)
{
	const unsigned int key = irq_lock();
	const struct inbox_stats copy = stats;

	irq_unlock(key);
	return copy;
}

/* --- the command thread ----------------------------------------------------------------------- */

void inbox_open(void)
{
	atomic_set(&is_open, 1);
}

struct inbox_item inbox_take(int64_t deadline_us)
{
	struct inbox_item item;

	if (k_msgq_get(&queue, &item, clock_timeout(deadline_us)) != 0) {
		item.kind = INBOX_WAKE;
	}
	return item;
}

void inbox_run(const struct inbox_item *item, struct pharos_device *device)
{
	item->call->result = item->call->function(device, item->call->argument);
}

void inbox_done(const struct inbox_item *item)
{
	switch (item->kind) {
	case INBOX_FRAME:
		stats.frames++;
		k_mem_slab_free(&frames, (void *)item->frame);
		break;
	case INBOX_CAN:
#ifdef CONFIG_CAN
		stats.can_frames++;
		k_mem_slab_free(&can_frames, (void *)item->can);
#endif
		break;
	case INBOX_IMC:
#ifdef CONFIG_PHAROS_IMC
		stats.imc_packets++;
		k_mem_slab_free(&imc_frames, (void *)item->imc);
#endif
		break;
	case INBOX_THERMAL:
		stats.thermal_reports++;
		break;
	case INBOX_CALL:
		stats.calls++;
		k_sem_give(&item->call->done);
		break;
	case INBOX_WAKE:
		break;
	}
}
