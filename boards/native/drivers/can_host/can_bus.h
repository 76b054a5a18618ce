/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CAN bus of the host: what --can0 names. Each kind is a back end in a folder of its own
 * (can_udp, can_socketcan). A bus that fails is retried and counted; it never ends the process.
 *
 * Frames go to the device as they come, or, in lock-step (virtual time with --control), are staged
 * until an `advance` releases them; then what the device sees does not depend on the host's timing.
 */
#ifndef CAN_BUS_H_
#define CAN_BUS_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "can_host_bus.h"
#include "host/buffer.h"
#include "host/error.h"
#include "host/loop.h"
#include "host/prng.h"

enum {
	CAN_BUS_URL_MAX = 120,
	CAN_BUS_FIFO = 1024,           /* events that the device has not taken: stops reading */
	CAN_BUS_STAGED_MAX = 16 << 20, /* bytes; lock-step: stops reading */
	CAN_BUS_RETRY_MIN_MS = 100,
	CAN_BUS_RETRY_MAX_MS = 2000,
};

/* Totals since power-on, in frames. */
struct can_bus_counts {
	uint64_t rx_frames;    /* as they came, before injected faults */
	uint64_t tx_frames;    /* as they were given to the host */
	uint64_t rx_malformed; /* what came and was no frame */
	uint64_t rx_drops;     /* lost in the host's full receive queue */
	uint64_t tx_retries;   /* the host's queue was full, or there was no bus */
	uint64_t errors;       /* of the host's side: gone, refused */
	uint64_t reconnects;
	uint64_t faults; /* frames that injected faults have hit */
};

/* Injected faults of one direction, in parts per million of the frames. */
struct can_bus_fault {
	uint32_t lost_ppm;
	uint32_t flipped_ppm;
	uint32_t doubled_ppm;
	uint32_t reordered_ppm;
	bool holding; /* `held` comes after the next frame */
	struct can_host_frame held;
};

/* A kind of bus. Only scheme, start and send are required. */
struct can_bus_type {
	const char *scheme;
	bool is_real; /* can_host_bus_is_real() */
	size_t state_size;
	/* What comes after "scheme:" ("" if nothing) into bus->state. 0, or -1 with a reason. */
	int (*parse)(struct can_bus *bus, const char *rest, struct host_error *error);
	/* Opens, or takes up what was carried over a reset. Also called for each retry. */
	void (*start)(struct can_bus *bus);
	void (*stop)(struct can_bus *bus);
	void (*save)(struct can_bus *bus);
	enum can_host_result (*send)(struct can_bus *bus, const struct can_host_frame *frame);
	void (*pause)(struct can_bus *bus, bool paused);
	/* Looks after counts that the host keeps. */
	void (*count)(struct can_bus *bus);
	void (*describe)(const struct can_bus *bus, char *text, size_t size);
};

struct can_bus {
	const char *name; /* "can0" */
	const struct can_bus_type *type;
	void *state;
	char url[CAN_BUS_URL_MAX];
	bool paced;
	struct can_host_client client;
	struct buffer staged; /* struct can_host_event each */
	struct buffer rx;
	bool paused;
	bool failing; /* said so; quiet until it works again */
	uint32_t retry_ms;
	struct loop_timer retry;
	/* Plain data, carried over resets. */
	struct can_bus_carried {
		struct can_bus_counts counts;
		uint64_t released; /* frames of counts.rx_frames that the device may have seen */
		bool gone;         /* injected: no interface */
		struct can_bus_fault rx_fault;
		struct can_bus_fault tx_fault;
		struct prng prng;
	} kept;
};

/* --- for the back ends ---------------------------------------------------------------------- */

/* A frame, or what a real controller tells, came. Then, once for a batch: can_bus_received_all().
 */
void can_bus_received(struct can_bus *bus, const struct can_host_event *event);
void can_bus_received_all(struct can_bus *bus);
void can_bus_malformed(struct can_bus *bus);

/* What could not be sent can be tried again. */
void can_bus_ready(struct can_bus *bus);

/* An error of the host's side, counted; the first of an outage is printed. */
void can_bus_error(struct can_bus *bus, const char *what, int error);

/* start() again later: 100 ms, then twice as long each time, up to 2 s. */
void can_bus_retry(struct can_bus *bus);

/* It works (again). */
void can_bus_works(struct can_bus *bus);

extern const struct can_bus_type can_bus_none, can_bus_udp, can_bus_socketcan;

/* --- for the option, the control operations and tests ---------------------------------------- */

/* Parses the option's value. 0, or -1 with a reason. */
int can_bus_parse(struct can_bus *bus, const char *url, struct host_error *error);

/* Lock-step: gives staged frames to the device until `total` have been released. */
void can_bus_release(struct can_bus *bus, uint64_t total);

/* Injected faults. The rated kinds are "lost", "flipped", "doubled" and "reordered". */
bool can_bus_is_rated_fault(const char *kind);
void can_bus_set_rate(struct can_bus *bus, const char *kind, bool rx, bool tx, uint32_t rate_ppm);
void can_bus_set_gone(struct can_bus *bus, bool gone);
void can_bus_end_faults(struct can_bus *bus);

/* The controller is bus-off now; it begins to recover hold_us later. */
void can_bus_force_off(struct can_bus *bus, uint32_t hold_us);

#endif
