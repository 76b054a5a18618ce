/* SPDX-License-Identifier: Apache-2.0 */
#include "can_bus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/clock.h"
#include "host/say.h"
#include "kernel/port.h"

/* --- injected faults ------------------------------------------------------------------------- */

static uint32_t *rate_of(struct can_bus_fault *fault, const char *kind)
{
	if (strcmp(kind, "lost") == 0) {
		return &fault->lost_ppm;
	}
	if (strcmp(kind, "flipped") == 0) {
		return &fault->flipped_ppm;
	}
	if (strcmp(kind, "doubled") == 0) {
		return &fault->doubled_ppm;
	}
	return strcmp(kind, "reordered") == 0 ? &fault->reordered_ppm : NULL;
}

bool can_bus_is_rated_fault(const char *kind)
{
	struct can_bus_fault fault;

	return rate_of(&fault, kind) != NULL;
}

void can_bus_set_rate(struct can_bus *bus, const char *kind, bool rx, bool tx, uint32_t rate_ppm)
{
	if (rx) {
		*rate_of(&bus->kept.rx_fault, kind) = rate_ppm;
	}
	if (tx) {
		*rate_of(&bus->kept.tx_fault, kind) = rate_ppm;
	}
}

void can_bus_set_gone(struct can_bus *bus, bool gone)
{
	const bool was_gone = bus->kept.gone;

	bus->kept.gone = gone;
	if (was_gone && !gone) {
		can_bus_ready(bus);
	}
}

void can_bus_end_faults(struct can_bus *bus)
{
	bus->kept.rx_fault = (struct can_bus_fault){0};
	bus->kept.tx_fault = (struct can_bus_fault){0};
	can_bus_set_gone(bus, false);
}

static bool hits(struct can_bus *bus, uint32_t ppm)
{
	const bool hit = prng_chance(&bus->kept.prng, ppm);

	bus->kept.counts.faults += hit ? 1 : 0;
	return hit;
}

/* --- bus to device --------------------------------------------------------------------------- */

static void set_paused(struct can_bus *bus, bool paused)
{
	if (bus->paused != paused) {
		bus->paused = paused;
		if (bus->type->pause != NULL) {
			bus->type->pause(bus, paused);
		}
	}
}

static void append(struct buffer *to, const struct can_host_event *event)
{
	buffer_append(to, event, sizeof(*event), SIZE_MAX / 2);
}

static void give_frame(struct can_bus *bus, const struct can_host_event *event)
{
	struct can_bus_fault *fault = &bus->kept.rx_fault;

	if (bus->kept.gone || hits(bus, fault->lost_ppm)) {
		return;
	}
	if (hits(bus, fault->flipped_ppm)) {
		append(&bus->rx, &(struct can_host_event){.kind = CAN_HOST_CRC_ERROR});
		return;
	}
	if (!fault->holding && hits(bus, fault->reordered_ppm)) {
		fault->holding = true;
		fault->held = event->frame;
		return;
	}
	append(&bus->rx, event);
	if (hits(bus, fault->doubled_ppm)) {
		append(&bus->rx, event);
	}
	if (fault->holding) {
		fault->holding = false;
		append(&bus->rx,
		       &(struct can_host_event){.kind = CAN_HOST_FRAME, .frame = fault->held});
	}
}

static void give(struct can_bus *bus, const struct can_host_event *event)
{
	if (event->kind != CAN_HOST_FRAME) {
		append(&bus->rx, event);
		return;
	}
	bus->kept.released++;
	port_trace("can-rx", bus->name, (int64_t)event->frame.id);
	give_frame(bus, event);
}

static void tell(struct can_bus *bus)
{
	if (bus->client.on_event != NULL && buffer_length(&bus->rx) > 0) {
		bus->client.on_event(bus->client.arg);
	}
}

void can_bus_received(struct can_bus *bus, const struct can_host_event *event)
{
	bus->kept.counts.rx_frames += event->kind == CAN_HOST_FRAME ? 1 : 0;
	if (clock_is_lockstep()) {
		append(&bus->staged, event);
	} else {
		give(bus, event);
	}
}

void can_bus_received_all(struct can_bus *bus)
{
	if (clock_is_lockstep()) {
		set_paused(bus, buffer_length(&bus->staged) >= CAN_BUS_STAGED_MAX);
		return;
	}
	tell(bus);
	set_paused(bus, buffer_length(&bus->rx) >= CAN_BUS_FIFO * sizeof(struct can_host_event));
}

void can_bus_malformed(struct can_bus *bus)
{
	bus->kept.counts.rx_malformed++;
}

void can_bus_release(struct can_bus *bus, uint64_t total)
{
	const struct can_host_event *event;

	while (buffer_length(&bus->staged) > 0) {
		event = (const struct can_host_event *)(const void *)buffer_bytes(&bus->staged);
		if (event->kind == CAN_HOST_FRAME && bus->kept.released >= total) {
			break;
		}
		give(bus, event);
		buffer_consume(&bus->staged, sizeof(*event));
	}
	set_paused(bus, false);
	tell(bus);
}

void can_bus_force_off(struct can_bus *bus, uint32_t hold_us)
{
	append(&bus->rx,
	       &(struct can_host_event){.kind = CAN_HOST_FORCE_BUS_OFF, .hold_us = hold_us});
	tell(bus);
}

const struct can_host_event *can_host_bus_peek(const struct can_bus *bus)
{
	return buffer_length(&bus->rx) > 0
	               ? (const struct can_host_event *)(const void *)buffer_bytes(&bus->rx)
	               : NULL;
}

void can_host_bus_drop(struct can_bus *bus)
{
	buffer_consume(&bus->rx, sizeof(struct can_host_event));
	if (bus->paused && !clock_is_lockstep() &&
	    buffer_length(&bus->rx) < CAN_BUS_FIFO / 2 * sizeof(struct can_host_event)) {
		set_paused(bus, false);
	}
}

/* --- device to bus --------------------------------------------------------------------------- */

static enum can_host_result send_one(struct can_bus *bus, const struct can_host_frame *frame)
{
	const enum can_host_result result = bus->type->send(bus, frame);

	if (result == CAN_HOST_SENT) {
		bus->kept.counts.tx_frames++;
	} else {
		bus->kept.counts.tx_retries++;
	}
	return result;
}

enum can_host_result can_host_bus_send(struct can_bus *bus, const struct can_host_frame *frame)
{
	struct can_bus_fault *fault = &bus->kept.tx_fault;
	enum can_host_result result;

	if (bus->kept.gone) {
		bus->kept.counts.tx_retries++;
		return CAN_HOST_NOBODY;
	}
	if (hits(bus, fault->flipped_ppm)) {
		return CAN_HOST_DESTROYED;
	}
	port_trace("can-tx", bus->name, (int64_t)frame->id);
	if (hits(bus, fault->lost_ppm)) {
		return CAN_HOST_SENT;
	}
	if (!fault->holding && hits(bus, fault->reordered_ppm)) {
		fault->holding = true;
		fault->held = *frame;
		return CAN_HOST_SENT;
	}
	result = send_one(bus, frame);
	if (result == CAN_HOST_SENT && hits(bus, fault->doubled_ppm)) {
		send_one(bus, frame);
	}
	if (result == CAN_HOST_SENT && fault->holding) {
		fault->holding = false;
		send_one(bus, &fault->held);
	}
	return result;
}

void can_bus_ready(struct can_bus *bus)
{
	if (bus->client.on_ready != NULL) {
		bus->client.on_ready(bus->client.arg);
	}
}

/* --- the device's side ----------------------------------------------------------------------- */

void can_host_bus_open(struct can_bus *bus, const struct can_host_client *client)
{
	bus->client = *client;
}

bool can_host_bus_is_real(const struct can_bus *bus)
{
	return bus->type->is_real;
}

bool can_host_bus_is_paced(const struct can_bus *bus)
{
	return bus->paced;
}

/* --- failure and retry ----------------------------------------------------------------------- */

void can_bus_error(struct can_bus *bus, const char *what, int error)
{
	bus->kept.counts.errors++;
	if (!bus->failing) {
		bus->failing = true;
		host_say("%s: %s: %s: %s; trying again", bus->name, bus->url, what,
		         strerror(error));
	}
}

static void on_retry(struct loop_timer *timer)
{
	struct can_bus *bus = timer->owner;

	bus->type->start(bus);
}

void can_bus_retry(struct can_bus *bus)
{
	bus->retry_ms = bus->retry_ms == 0 ? CAN_BUS_RETRY_MIN_MS : 2 * bus->retry_ms;
	if (bus->retry_ms > CAN_BUS_RETRY_MAX_MS) {
		bus->retry_ms = CAN_BUS_RETRY_MAX_MS;
	}
	bus->retry.fire = on_retry;
	bus->retry.owner = bus;
	loop_timer_start(&bus->retry, bus->retry_ms);
}

void can_bus_works(struct can_bus *bus)
{
	bus->retry_ms = 0;
	if (bus->failing) {
		bus->failing = false;
		bus->kept.counts.reconnects++;
		host_say("%s: %s: works again", bus->name, bus->url);
		can_bus_ready(bus);
	}
}

/* --- no bus ---------------------------------------------------------------------------------- */

/* Nothing is connected: nobody acknowledges. */
static enum can_host_result send_to_nobody(struct can_bus *bus, const struct can_host_frame *frame)
{
	(void)bus;
	(void)frame;
	return CAN_HOST_NOBODY;
}

static void start_nothing(struct can_bus *bus)
{
	(void)bus;
}

const struct can_bus_type can_bus_none = {
	.scheme = "none",
	.start = start_nothing,
	.send = send_to_nobody,
};
