/* SPDX-License-Identifier: Apache-2.0 */
/* What a wire is made of (host/wire.h), its peers among it (host/wire_peers.h). */
#ifndef NATIVE_HOST_WIRE_STATE_H_
#define NATIVE_HOST_WIRE_STATE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "host/buffer.h"
#include "host/error.h"
#include "host/loop.h"
#include "host/prng.h"

enum {
	WIRE_PEERS_MAX = 8,
	WIRE_NOBODY = WIRE_PEERS_MAX, /* whoever has no place: heard, and not answered */
	WIRE_VOICES = WIRE_PEERS_MAX + 1,
	WIRE_MESSAGE_MAX = 8192, /* a longer one is no message */
};

enum wire_framing {
	WIRE_FRAMING_NONE, /* every byte for itself: a console */
	WIRE_FRAMING_MAVLINK,
	WIRE_FRAMING_IMC,
};

/* Plain data, carried over resets. Board time. */
struct wire_peer {
	struct sockaddr_storage address;
	uint64_t since_us;
	uint64_t heard_us;
	bool present;
	bool spoke; /* a whole message */
};

/* What a voice has said and the device has not got. */
struct wire_voice {
	struct buffer held;
	uint64_t heard_us;
	size_t rest; /* of a message whose beginning the device has got */
};

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
	/* wire.c's, for wire_peers.c: bytes to the device, in the order of the calls; a peer's
	 * place is free, and what it has not said to the end is left out. */
	void (*give)(struct wire *wire, const uint8_t *data, size_t length);
	void (*leave)(struct wire *wire, int peer);
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

#endif
