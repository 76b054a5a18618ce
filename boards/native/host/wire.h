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

#include "host/error.h"
#include "host/wire_peers.h"
#include "host/wire_state.h"

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

/* --- for the types of wires ------------------------------------------------------------------- */

/*
 * Bytes came; of one of several peers (a place, or WIRE_NOBODY): the second. Then, once for a
 * batch: wire_received_all().
 */
void wire_received(struct wire *wire, const uint8_t *data, size_t length);
void wire_received_of(struct wire *wire, int voice, const uint8_t *data, size_t length);
void wire_received_all(struct wire *wire);

/* Its place is free; what it has not said to the end is left out. */
void wire_peer_leave(struct wire *wire, int peer);

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
