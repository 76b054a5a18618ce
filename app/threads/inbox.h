/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the command thread has to do: frames of every protocol in buffers of pools, thermal reports,
 * and functions that others have it run, because it alone may touch the device and the protocols.
 */
#ifndef PHAROS_THREADS_INBOX_H
#define PHAROS_THREADS_INBOX_H

#include <stddef.h>
#include <stdint.h>

#include "core/device.h"
#include "threads/supervisor.h"

/* threads/frames.h */
struct link_frame;
struct dronecan_frame;
struct imc_frame;
struct imc_route;
struct inbox_call;

enum inbox_kind {
	INBOX_FRAME,
	INBOX_CAN,
	INBOX_IMC,
	INBOX_THERMAL,
	INBOX_CALL,
	INBOX_WAKE, /* look after what is due */
};

struct inbox_item {
	enum inbox_kind kind;
	union {
		struct link_frame *frame;
		struct dronecan_frame *can;
		struct imc_frame *imc;
		struct thermal_report thermal;
		struct inbox_call *call;
	};
};

struct inbox_stats {
	uint32_t frames;
	uint32_t can_frames;
	uint32_t imc_packets;
	uint32_t thermal_reports;
	uint32_t calls;
	uint32_t reports_dropped; /* the queue was full: the next report comes in 100 ms */
};

/* --- for link threads ------------------------------------------------------------------------- */

/*
 * Copies what has been received into a buffer of its pool, for the command thread. Waits while that
 * is behind, and meanwhile reports to the supervisor as watch.
 */
void inbox_post_frame(uint8_t link, const uint8_t *bytes, size_t length,
                      enum supervisor_watch watch);
#ifdef CONFIG_CAN
void inbox_post_can(const struct dronecan_frame *frame, enum supervisor_watch watch);
#endif
#ifdef CONFIG_PHAROS_IMC
void inbox_post_imc(const struct imc_route *route, const uint8_t *bytes, size_t length,
                    enum supervisor_watch watch);
#endif

/* --- for anyone ------------------------------------------------------------------------------- */

/* Something that the command thread waits for may have happened: it looks. Any context. */
void inbox_wake(void);

/* Never waits; a full queue drops the report and counts. Thermal thread. */
void inbox_post_thermal(const struct thermal_report *report);

/*
 * Runs function(device, argument) in the command thread and returns what it returned, once all that
 * followed from it has been performed. While the device starts it waits for that. A command thread
 * that does not come to it is a stall, which ends in a reset. -EAGAIN, which no function returns:
 * the device has started and the thread does not run; nothing was done. Any thread but the command
 * thread.
 */
int inbox_call(int (*function)(struct pharos_device *device, void *argument), void *argument);

/* Counters; any thread. */
struct inbox_stats inbox_stats_get(void);

/* --- for the command thread ------------------------------------------------------------------- */

/* It runs: calls are taken from now on. */
void inbox_open(void);

/* Waits until then. INBOX_WAKE: nothing came. */
struct inbox_item inbox_take(int64_t deadline_us);

/* Runs the function of an INBOX_CALL. */
void inbox_run(const struct inbox_item *item, struct pharos_device *device);

/* Gives back what the item holds: its buffer, or its caller's freedom. */
void inbox_done(const struct inbox_item *item);

#endif
