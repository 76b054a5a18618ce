/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A wire: the bytes between a UART of the device and something of the host, named by a URL. One
 * write of the device is one datagram. A wire that fails is retried and counted; it never ends the
 * process.
 *
 * Real time, and virtual time running free: bytes go to the device as they come. The rest stays in
 * the host's socket while the device has WIRE_FIFO bytes unread. Lock-step (virtual time with
 * --control): bytes are staged until an `advance` releases them, so that what the device sees does
 * not depend on the host's timing.
 */
#ifndef NATIVE_HOST_WIRE_H_
#define NATIVE_HOST_WIRE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/buffer.h"
#include "host/error.h"
#include "host/loop.h"
#include "host/prng.h"
#include "host/wire_peers.h"

enum {
	WIRES_MAX = 16,
	WIRE_URL_MAX = 160,
	WIRE_FIFO = 4096,           /* unread by the device: stops reading the host's side */
	WIRE_READ = 16384,          /* of a stream, in one read */
	WIRE_HELD_MAX = 65536,      /* of peers whose messages are not whole: as well */
	WIRE_STAGED_MAX = 16 << 20, /* lock-step: read and not yet released */
	WIRE_BACKLOG_MAX = 1 << 20, /* of a stream: written, not yet taken by the host */
	WIRE_BATCH = 32,            /* datagrams gathered before a flush */
	WIRE_BATCH_BYTES = 32768,
	WIRE_DATAGRAM_MAX = 4096, /* longer writes are taken in part */
	WIRE_COALESCE = 256,      /* single bytes gathered into one datagram */
	WIRE_RETRY_MIN_MS = 100,
	WIRE_RETRY_MAX_MS = 5000,
};

/* Totals since power-on. */
struct wire_counts {
	uint64_t rx_bytes;     /* as read from the host: before injected faults */
	uint64_t tx_bytes;     /* as given to the host, once however many peers there are */
	uint64_t rx_datagrams; /* of a stream: reads */
	uint64_t tx_datagrams; /* of a stream: writes of the device */
	uint64_t tx_drops;     /* bytes that nobody took: no peer, no room, send failed */
	uint64_t errors;
	uint64_t reconnects;
	uint64_t faults; /* bytes changed by injected faults */
};

/* Injected faults of one direction, in parts per million of the bytes. */
struct wire_fault {
	uint32_t lost_ppm;
	uint32_t flipped_ppm;
	uint32_t doubled_ppm;
};

struct wire;

/* A kind of wire. All but scheme, syntax, help, parse, start, stop and send may be NULL. */
struct wire_type {
	const char *scheme; /* "udpin" */
	const char *syntax; /* "udpin:HOST:PORT" */
	const char *help;
	size_t state_size;
	/* What comes after "scheme:" ("" if nothing) into wire->state. 0, or -1 with a reason. */
	int (*parse)(struct wire *wire, const char *rest, struct host_error *error);
	/* Opens, or takes up what was carried over a reset. Also called for each retry. */
	void (*start)(struct wire *wire);
	/* End of the process. */
	void (*stop)(struct wire *wire);
	/* `count` datagrams, their bytes one after the other. Reports wire_sent(), wire_dropped().
	 */
	void (*send)(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count);
	/* Stop or resume reading. */
	void (*pause)(struct wire *wire, bool paused);
	/* Lock-step: look now at what the loop is not told about. */
	void (*poke)(struct wire *wire);
	void (*save)(struct wire *wire);
	int (*set_baud)(struct wire *wire, uint32_t baud);
	/* The URL with what was chosen at run time filled in. */
	void (*describe)(const struct wire *wire, char *text, size_t size);
};

struct wire {
	const char *name; /* "uart0" */
	const struct wire_type *type;
	void *state;
	char url[WIRE_URL_MAX];
	void (*on_rx)(void *arg); /* more to read for the device; in interrupt context */
	void *arg;
	enum wire_framing framing;
	struct buffer staged;
	struct buffer staged_parts; /* struct wire_part: whose bytes those are */
	struct wire_voice voices[WIRE_VOICES];
	struct buffer rx;
	struct buffer tx;
	uint32_t tx_length[WIRE_BATCH];
	size_t tx_count;
	bool tx_open; /* the last datagram may still grow */
	bool dirty;
	bool paused;
	bool failing; /* said so; quiet until it works again */
	uint32_t retry_ms;
	struct loop_timer retry;
	/* Plain data, carried over resets. */
	struct wire_carried {
		struct wire_counts counts;
		uint64_t released; /* bytes of counts.rx_bytes that the device may have seen */
		struct wire_fault rx_fault;
		struct wire_fault tx_fault;
		struct prng prng;
		struct wire_peer peers[WIRE_PEERS_MAX];
	} kept;
};

/* Of staged bytes. length 0: the voice is a new peer's from here on. */
struct wire_part {
	int voice; /* WIRE_VOICES: the wire has one peer only */
	size_t length;
};

/* --- for the device's side (../drivers/uart_host) --------------------------------------------- */

/* Parses a URL into an unused wire, whose name is set. 0, or -1 with a reason. Before
 * wires_start(). */
int wire_parse(struct wire *wire, const char *url, struct host_error *error);

/* Includes it in the loop, in `advance` and in the control operations. */
void wire_add(struct wire *wire);

size_t wire_available(const struct wire *wire);
size_t wire_read(struct wire *wire, uint8_t *data, size_t size);

/* One datagram; how many bytes were taken (all, up to WIRE_DATAGRAM_MAX). Sent when the kernel goes
 * idle. */
size_t wire_write(struct wire *wire, const uint8_t *data, size_t length);

/* One byte; gathered into a datagram up to a line feed, WIRE_COALESCE bytes, or the kernel going
 * idle. */
void wire_put(struct wire *wire, uint8_t byte);

/* Bytes of peers that are kept until their messages are whole (wire_peers.h): how long from now
 * they may wait (0: there are none), and giving them up when that is over. */
uint64_t wire_hold_us(const struct wire *wire);
void wire_expire(struct wire *wire);

/* --- for the loop and the control operations ------------------------------------------------- */

struct wire *wire_find(const char *name);

/* The i-th wire; NULL beyond the last. */
struct wire *wire_at(size_t i);

void wires_flush(void);

/* Lock-step: explicit look at every wire. */
void wires_poke(void);

/* Lock-step: gives staged bytes to the device until `total` bytes have been released; true: there
 * were some. */
bool wire_release(struct wire *wire, uint64_t total);

void wire_describe(const struct wire *wire, char *text, size_t size);

/* --- for wire_peers.c ------------------------------------------------------------------------- */

/* To the device, in the order of the calls. */
void wire_give(struct wire *wire, const uint8_t *data, size_t length);

/* --- for the types of wires ------------------------------------------------------------------- */

/*
 * Bytes came; of one of several peers (a place, or WIRE_NOBODY): the second. Then, once for a
 * batch: wire_received_all().
 */
void wire_received(struct wire *wire, const uint8_t *data, size_t length);
void wire_received_of(struct wire *wire, int voice, const uint8_t *data, size_t length);
void wire_received_all(struct wire *wire);

void wire_sent(struct wire *wire, size_t bytes, size_t datagrams);
void wire_dropped(struct wire *wire, size_t bytes);

/* An error of the host's side, counted; the first of an outage is printed. */
void wire_error(struct wire *wire, const char *what, int error);

/* start() again later: 100 ms, then twice as long each time, up to 5 s. */
void wire_retry(struct wire *wire);

/* It works (again): counted as a reconnect if it had failed. */
void wire_works(struct wire *wire);

/* Bytes that a stream may keep for a slow reader: much more when nobody reads until an advance is
 * over. */
size_t wire_backlog_max(void);

extern const struct wire_type wire_none, wire_stdio, wire_udpin, wire_udpout, wire_udppair,
	wire_tcp, wire_tcpin, wire_pty, wire_serial;

/* All types, ended by NULL. */
extern const struct wire_type *const wire_types[];

#endif
