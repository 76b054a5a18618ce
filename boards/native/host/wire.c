/* SPDX-License-Identifier: Apache-2.0 */
#include "host/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/module.h"
#include "host/say.h"
#include "kernel/port.h"

const struct wire_type *const wire_types[] = {
	&wire_udpin, &wire_udpout, &wire_udppair, &wire_tcp,  &wire_tcpin,
	&wire_pty,   &wire_serial, &wire_stdio,   &wire_none, NULL,
};

static struct wire *wires[WIRES_MAX];
static size_t wire_count;
static size_t dirty_count;

int wire_parse(struct wire *wire, const char *url, struct host_error *error)
{
	const size_t scheme = strcspn(url, ":");

	if (strlen(url) >= sizeof(wire->url)) {
		return host_error_set(error, "longer than %d characters", WIRE_URL_MAX - 1);
	}
	for (size_t i = 0; wire_types[i] != NULL; i++) {
		const struct wire_type *type = wire_types[i];

		if (strlen(type->scheme) != scheme || memcmp(type->scheme, url, scheme) != 0) {
			continue;
		}
		free(wire->state);
		wire->type = type;
		wire->state = calloc(1, type->state_size + 1);
		if (wire->state == NULL) {
			abort();
		}
		strcpy(wire->url, url);
		return type->parse(wire, url[scheme] == ':' ? url + scheme + 1 : "", error);
	}
	return host_error_set(
		error,
		"\"%.40s\" is no wire; udpin:, udpout:, udppair:, tcp:, tcpin:, pty:, "
		"serial:, stdio and none are",
		url);
}

static void give(struct wire *wire, const uint8_t *data, size_t length);

void wire_add(struct wire *wire)
{
	wire->give = give;
	wire->leave = wire_peer_leave;
	if (wire_count == WIRES_MAX) {
		abort();
	}
	wires[wire_count++] = wire;
}

struct wire *wire_at(size_t i)
{
	return i < wire_count ? wires[i] : NULL;
}

struct wire *wire_find(const char *name)
{
	for (size_t i = 0; i < wire_count; i++) {
		if (strcmp(wires[i]->name, name) == 0) {
			return wires[i];
		}
	}
	return NULL;
}

void wire_describe(const struct wire *wire, char *text, size_t size)
{
	if (wire->type->describe != NULL) {
		wire->type->describe(wire, text, size);
	} else {
		snprintf(text, size, "%s", wire->url);
	}
}

size_t wire_backlog_max(void)
{
	return clock_is_virtual() ? WIRE_STAGED_MAX : WIRE_BACKLOG_MAX;
}

/* --- injected faults -----------------------------------------------------------------------------
 */

static bool has_fault(const struct wire_fault *fault)
{
	return (fault->lost_ppm | fault->flipped_ppm | fault->doubled_ppm) != 0;
}

/* Appends `length` bytes with faults applied; how many it became. */
static size_t append_faulty(struct wire *wire, const struct wire_fault *fault, struct buffer *to,
                            const uint8_t *data, size_t length)
{
	uint8_t *room = buffer_reserve(to, 2 * length, SIZE_MAX / 2);
	size_t n = 0;

	for (size_t i = 0; i < length; i++) {
		uint8_t byte = data[i];

		if (prng_chance(&wire->kept.prng, fault->lost_ppm)) {
			wire->kept.counts.faults++;
			continue;
		}
		if (prng_chance(&wire->kept.prng, fault->flipped_ppm)) {
			wire->kept.counts.faults++;
			byte ^= (uint8_t)(1u << prng_below(&wire->kept.prng, 8));
		}
		room[n++] = byte;
		if (prng_chance(&wire->kept.prng, fault->doubled_ppm)) {
			wire->kept.counts.faults++;
			room[n++] = byte;
		}
	}
	to->tail += n;
	return n;
}

/* --- host to device ------------------------------------------------------------------------------
 */

static void set_paused(struct wire *wire, bool paused)
{
	if (wire->paused != paused) {
		wire->paused = paused;
		if (wire->type->pause != NULL) {
			wire->type->pause(wire, paused);
		}
	}
}

static void give(struct wire *wire, const uint8_t *data, size_t length)
{
	port_trace("rx", wire->name, (int64_t)length);
	if (has_fault(&wire->kept.rx_fault)) {
		append_faulty(wire, &wire->kept.rx_fault, &wire->rx, data, length);
	} else {
		buffer_append(&wire->rx, data, length, SIZE_MAX / 2);
	}
}

/* Bytes are released to the device's end. */
static void release(struct wire *wire, int voice, const uint8_t *data, size_t length)
{
	wire->kept.released += length;
	if (voice == WIRE_VOICES) {
		give(wire, data, length);
	} else if (length == 0) {
		wire_voice_reset(wire, voice);
	} else {
		wire_voice_said(wire, voice, data, length);
	}
}

static void received(struct wire *wire, int voice, const uint8_t *data, size_t length)
{
	if (clock_is_lockstep()) {
		const struct wire_part part = {voice, length};

		buffer_append(&wire->staged, data, length, SIZE_MAX / 2);
		buffer_append(&wire->staged_parts, &part, sizeof(part), SIZE_MAX / 2);
	} else {
		release(wire, voice, data, length);
	}
}

void wire_received_of(struct wire *wire, int voice, const uint8_t *data, size_t length)
{
	wire->kept.counts.rx_bytes += length;
	wire->kept.counts.rx_datagrams++;
	if (length > 0) {
		received(wire, voice, data, length);
	}
}

void wire_received(struct wire *wire, const uint8_t *data, size_t length)
{
	wire_received_of(wire, WIRE_VOICES, data, length);
}

void wire_peer_leave(struct wire *wire, int peer)
{
	wire->kept.peers[peer].present = false;
	received(wire, peer, NULL, 0);
	if (!clock_is_lockstep()) {
		wire_received_all(wire);
	}
}

static size_t held(const struct wire *wire)
{
	size_t length = 0;

	for (int i = 0; i < WIRE_VOICES; i++) {
		length += buffer_length(&wire->voices[i].held);
	}
	return length;
}

void wire_received_all(struct wire *wire)
{
	if (clock_is_lockstep()) {
		set_paused(wire, buffer_length(&wire->staged) >= WIRE_STAGED_MAX);
		return;
	}
	set_paused(wire, buffer_length(&wire->rx) >= WIRE_FIFO || held(wire) >= WIRE_HELD_MAX);
	if (wire->on_rx != NULL && (buffer_length(&wire->rx) > 0 || held(wire) > 0)) {
		wire->on_rx(wire->arg);
	}
}

uint64_t wire_hold_us(const struct wire *wire)
{
	return wire_voices_hold_us(wire);
}

void wire_expire(struct wire *wire)
{
	wire_voices_expire(wire);
	if (!clock_is_lockstep()) {
		wire_received_all(wire);
	} else if (wire->on_rx != NULL) {
		wire->on_rx(wire->arg);
	}
}

/* The next `count` staged bytes, and whose they are; parts of nothing before and behind them too.
 */
static void release_staged(struct wire *wire, size_t count)
{
	while (buffer_length(&wire->staged_parts) > 0) {
		struct wire_part *const part =
			(struct wire_part *)(void *)(wire->staged_parts.data +
		                                     wire->staged_parts.head);
		const size_t n = part->length < count ? part->length : count;

		if (part->length > 0 && n == 0) {
			return;
		}
		release(wire, part->voice, buffer_bytes(&wire->staged), n);
		buffer_consume(&wire->staged, n);
		count -= n;
		part->length -= n;
		if (part->length == 0) {
			buffer_consume(&wire->staged_parts, sizeof(*part));
		}
	}
}

bool wire_release(struct wire *wire, uint64_t total)
{
	const size_t staged = buffer_length(&wire->staged);
	size_t n = 0;

	if (total > wire->kept.released) {
		n = total - wire->kept.released < staged ? (size_t)(total - wire->kept.released)
		                                         : staged;
	}
	if (n == 0) {
		return false;
	}
	release_staged(wire, n);
	set_paused(wire, false);
	if (wire->on_rx != NULL) {
		wire->on_rx(wire->arg);
	}
	return true;
}

size_t wire_available(const struct wire *wire)
{
	return buffer_length(&wire->rx);
}

size_t wire_read(struct wire *wire, uint8_t *data, size_t size)
{
	const size_t length = buffer_length(&wire->rx);
	const size_t n = size < length ? size : length;

	if (n > 0) {
		memcpy(data, buffer_bytes(&wire->rx), n);
		buffer_consume(&wire->rx, n);
		if (wire->paused && !clock_is_lockstep() && length - n < WIRE_FIFO) {
			set_paused(wire, false);
		}
	}
	return n;
}

/* --- device to host ------------------------------------------------------------------------------
 */

static void flush(struct wire *wire)
{
	const size_t count = wire->tx_count;

	wire->tx_open = false;
	wire->dirty = false;
	wire->tx_count = 0;
	dirty_count--;
	if (buffer_length(&wire->tx) > 0) {
		wire->type->send(wire, buffer_bytes(&wire->tx), wire->tx_length, count);
	}
	buffer_consume(&wire->tx, buffer_length(&wire->tx));
}

void wires_flush(void)
{
	for (size_t i = 0; dirty_count > 0 && i < wire_count; i++) {
		if (wires[i]->dirty) {
			flush(wires[i]);
		}
	}
}

static void append(struct wire *wire, const uint8_t *data, size_t length, bool more)
{
	size_t n = length;

	if (wire->type == &wire_none) {
		return;
	}
	port_trace("tx", wire->name, (int64_t)length);
	if (has_fault(&wire->kept.tx_fault)) {
		n = append_faulty(wire, &wire->kept.tx_fault, &wire->tx, data, length);
	} else {
		buffer_append(&wire->tx, data, length, SIZE_MAX / 2);
	}
	if (n == 0) {
		return; /* all lost */
	}
	if (wire->tx_open) {
		wire->tx_length[wire->tx_count - 1] += (uint32_t)n;
	} else {
		wire->tx_length[wire->tx_count++] = (uint32_t)n;
	}
	wire->tx_open = more && wire->tx_length[wire->tx_count - 1] < WIRE_COALESCE;
	if (!wire->dirty) {
		wire->dirty = true;
		dirty_count++;
	}
	if ((wire->tx_count == WIRE_BATCH && !wire->tx_open) ||
	    buffer_length(&wire->tx) >= WIRE_BATCH_BYTES) {
		flush(wire);
	}
}

size_t wire_write(struct wire *wire, const uint8_t *data, size_t length)
{
	const size_t n = length < WIRE_DATAGRAM_MAX ? length : WIRE_DATAGRAM_MAX;

	wire_voices_learn(wire, data, n);
	if (wire->tx_open) {
		wire->tx_open = false;
		if (wire->tx_count == WIRE_BATCH) {
			flush(wire);
		}
	}
	append(wire, data, n, false);
	return n;
}

void wire_put(struct wire *wire, uint8_t byte)
{
	append(wire, &byte, 1, byte != '\n');
}

void wire_sent(struct wire *wire, size_t bytes, size_t datagrams)
{
	wire->kept.counts.tx_bytes += bytes;
	wire->kept.counts.tx_datagrams += datagrams;
}

void wire_dropped(struct wire *wire, size_t bytes)
{
	wire->kept.counts.tx_drops += bytes;
}

/* --- failure and retry ---------------------------------------------------------------------------
 */

void wire_error(struct wire *wire, const char *what, int error)
{
	wire->kept.counts.errors++;
	if (!wire->failing) {
		wire->failing = true;
		host_say("%s: %s: %s: %s; trying again", wire->name, wire->url, what,
		         strerror(error));
	}
}

static void on_retry(struct loop_timer *timer)
{
	struct wire *wire = timer->owner;

	wire->type->start(wire);
}

void wire_retry(struct wire *wire)
{
	wire->retry_ms = wire->retry_ms == 0 ? WIRE_RETRY_MIN_MS : 2 * wire->retry_ms;
	if (wire->retry_ms > WIRE_RETRY_MAX_MS) {
		wire->retry_ms = WIRE_RETRY_MAX_MS;
	}
	loop_timer_start(&wire->retry, wire->retry_ms);
}

void wire_works(struct wire *wire)
{
	wire->retry_ms = 0;
	if (wire->failing) {
		wire->failing = false;
		wire->kept.counts.reconnects++;
		host_say("%s: %s: works again", wire->name, wire->url);
	}
}

void wires_poke(void)
{
	for (size_t i = 0; i < wire_count; i++) {
		struct wire *wire = wires[i];

		if (wire->retry.running) {
			loop_timer_stop(&wire->retry);
			wire->type->start(wire);
		}
		if (wire->type->poke != NULL) {
			wire->type->poke(wire);
		}
	}
}

/* --- start and end -------------------------------------------------------------------------------
 */

static void carry_names(const struct wire *wire, char *kept, char *staged, char *parts, size_t size)
{
	snprintf(kept, size, "wire/%s/kept", wire->name);
	snprintf(staged, size, "wire/%s/staged", wire->name);
	snprintf(parts, size, "wire/%s/parts", wire->name);
}

static int start(void)
{
	for (size_t i = 0; i < wire_count; i++) {
		struct wire *wire = wires[i];
		char kept_name[48];
		char staged_name[48];
		char parts_name[48];
		char text[WIRE_URL_MAX + 64];
		size_t size;
		const void *old;

		carry_names(wire, kept_name, staged_name, parts_name, sizeof(kept_name));
		prng_init(&wire->kept.prng, wire->name);
		old = carry_get(kept_name, &size);
		if (old != NULL && size == sizeof(wire->kept)) {
			memcpy(&wire->kept, old, size);
		}
		old = carry_get(staged_name, &size);
		buffer_append(&wire->staged, old, size, SIZE_MAX / 2);
		old = carry_get(parts_name, &size);
		buffer_append(&wire->staged_parts, old, size, SIZE_MAX / 2);
		wire->retry.fire = on_retry;
		wire->retry.owner = wire;
		wire->type->start(wire);
		wire_describe(wire, text, sizeof(text));
		if (!carry_is_reset() && wire->type != &wire_none && wire->type != &wire_stdio) {
			host_say("%s is %s", wire->name, text);
		}
	}
	return 0;
}

static void save(void)
{
	for (size_t i = 0; i < wire_count; i++) {
		struct wire *wire = wires[i];
		char kept_name[48];
		char staged_name[48];
		char parts_name[48];

		/* What was in the device's receive register is lost in a reset. */
		carry_names(wire, kept_name, staged_name, parts_name, sizeof(kept_name));
		carry_put(kept_name, &wire->kept, sizeof(wire->kept));
		carry_put(staged_name, buffer_bytes(&wire->staged), buffer_length(&wire->staged));
		carry_put(parts_name, buffer_bytes(&wire->staged_parts),
		          buffer_length(&wire->staged_parts));
		if (wire->type->save != NULL) {
			wire->type->save(wire);
		}
	}
}

static void stop(void)
{
	for (size_t i = 0; i < wire_count; i++) {
		struct wire *wire = wires[i];

		loop_timer_stop(&wire->retry);
		wire->type->stop(wire);
		free(wire->state);
		wire->state = NULL;
		buffer_free(&wire->staged);
		buffer_free(&wire->staged_parts);
		wire_voices_free(wire);
		buffer_free(&wire->rx);
		buffer_free(&wire->tx);
	}
	wire_count = 0;
}

HOST_MODULE(wire_module) = {
	.name = "wires",
	.order = HOST_ORDER_WIRES,
	.start = start,
	.save = save,
	.stop = stop,
};

/* --- none ----------------------------------------------------------------------------------------
 */

static int none_parse(struct wire *wire, const char *rest, struct host_error *error)
{
	(void)wire;
	if (rest[0] != '\0') {
		return host_error_set(error, "none takes nothing after it");
	}
	return 0;
}

static void none_start(struct wire *wire)
{
	(void)wire;
}

static void none_send(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count)
{
	(void)wire;
	(void)data;
	(void)length;
	(void)count;
}

const struct wire_type wire_none = {
	.scheme = "none",
	.syntax = "none",
	.help = "not connected",
	.parse = none_parse,
	.start = none_start,
	.stop = none_start,
	.send = none_send,
};
