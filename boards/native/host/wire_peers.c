/* SPDX-License-Identifier: Apache-2.0 */
#include "host/wire_peers.h"

#include "host/address.h"
#include "host/clock.h"

/* --- where a message ends --------------------------------------------------------------------- */

/* Bytes of the message that begins here; 0: none does; SIZE_MAX: too few to tell. */
static size_t mavlink_length(const uint8_t *bytes, size_t count)
{
	enum {
		V1 = 0xFE,
		V1_AROUND = 8, /* header, checksum */
		V2 = 0xFD,
		V2_AROUND = 12,
		SIGNED = 1,
		SIGNATURE = 13,
	};

	if (bytes[0] == V1) {
		return count < 2 ? SIZE_MAX : V1_AROUND + (size_t)bytes[1];
	}
	if (bytes[0] != V2) {
		return 0;
	}
	if (count < 3) {
		return SIZE_MAX;
	}
	return V2_AROUND + (size_t)bytes[1] + ((bytes[2] & SIGNED) != 0 ? SIGNATURE : 0);
}

static size_t imc_length(const uint8_t *bytes, size_t count)
{
	enum {
		LOW = 0x54,
		HIGH = 0xFE,
		AROUND = 22, /* header, checksum */
	};

	if (bytes[0] != LOW && bytes[0] != HIGH) {
		return 0;
	}
	if (count < 2) {
		return SIZE_MAX;
	}
	if (bytes[1] != (bytes[0] == LOW ? HIGH : LOW)) {
		return 0;
	}
	if (count < 6) {
		return SIZE_MAX;
	}
	return AROUND + (bytes[0] == LOW ? bytes[4] | (size_t)bytes[5] << 8
	                                 : bytes[5] | (size_t)bytes[4] << 8);
}

static size_t message_length(const struct wire *wire, const uint8_t *bytes, size_t count)
{
	size_t length = 0;

	switch (wire->framing) {
	case WIRE_FRAMING_NONE:
		break;
	case WIRE_FRAMING_MAVLINK:
		length = mavlink_length(bytes, count);
		break;
	case WIRE_FRAMING_IMC:
		length = imc_length(bytes, count);
		break;
	}
	return length != SIZE_MAX && length > WIRE_MESSAGE_MAX ? 0 : length;
}

void wire_voices_learn(struct wire *wire, const uint8_t *data, size_t length)
{
	if (wire->framing == WIRE_FRAMING_NONE || length < 2) {
		return;
	}
	if (data[0] == 0x54 && data[1] == 0xFE) {
		wire->framing = WIRE_FRAMING_IMC;
	} else if (data[0] == 0xFD || data[0] == 0xFE) {
		wire->framing = WIRE_FRAMING_MAVLINK;
	}
}

/* --- turns ------------------------------------------------------------------------------------ */

static bool is_alone(const struct wire *wire)
{
	unsigned int present = 0;

	for (int i = 0; i < WIRE_PEERS_MAX; i++) {
		present += wire->kept.peers[i].present;
	}
	return present <= 1;
}

static bool is_over(const struct wire_voice *voice)
{
	return clock_board_us() - voice->heard_us >= WIRE_HOLD_US;
}

/* Of whom the device has got the beginning of a message; NULL: of nobody. */
static struct wire_voice *whose_turn(struct wire *wire)
{
	for (int i = 0; i < WIRE_VOICES; i++) {
		if (wire->voices[i].rest > 0) {
			return &wire->voices[i];
		}
	}
	return NULL;
}

static void pass(struct wire *wire, struct wire_voice *voice, size_t count)
{
	wire->give(wire, buffer_bytes(&voice->held), count);
	buffer_consume(&voice->held, count);
}

static void note_message(struct wire *wire, int voice)
{
	if (voice < WIRE_PEERS_MAX) {
		wire->kept.peers[voice].spoke = true;
	}
}

/* As much as may go on; false: nothing. */
static bool go_on(struct wire *wire, int i)
{
	struct wire_voice *const voice = &wire->voices[i];
	const size_t count = buffer_length(&voice->held);
	size_t length;

	if (count == 0) {
		return false;
	}
	if (voice->rest > 0) {
		const size_t n = count < voice->rest ? count : voice->rest;

		voice->rest -= n;
		pass(wire, voice, n);
		return true;
	}
	length = message_length(wire, buffer_bytes(&voice->held), count);
	if (length == 0) {
		size_t run = 1;

		if (wire->framing == WIRE_FRAMING_NONE) {
			note_message(wire, i);
		}
		while (run < count &&
		       message_length(wire, buffer_bytes(&voice->held) + run, count - run) == 0) {
			run++;
		}
		pass(wire, voice, run);
		return true;
	}
	if (length <= count) {
		note_message(wire, i);
		pass(wire, voice, length);
		return true;
	}
	if (is_over(voice)) {
		pass(wire, voice, count);
		return true;
	}
	if (length != SIZE_MAX && is_alone(wire)) {
		voice->rest = length - count;
		pass(wire, voice, count);
		return true;
	}
	return false;
}

static void take_turns(struct wire *wire)
{
	bool moved;

	do {
		struct wire_voice *turn;

		moved = false;
		for (int i = 0; i < WIRE_VOICES; i++) {
			turn = whose_turn(wire);
			if (turn == NULL || turn == &wire->voices[i]) {
				moved |= go_on(wire, i);
			}
		}
	} while (moved);
}

void wire_voice_said(struct wire *wire, int i, const uint8_t *data, size_t length)
{
	struct wire_voice *const voice = &wire->voices[i];

	voice->heard_us = clock_board_us();
	if (i < WIRE_PEERS_MAX) {
		wire->kept.peers[i].heard_us = voice->heard_us;
	}
	buffer_append(&voice->held, data, length, SIZE_MAX / 2);
	take_turns(wire);
}

void wire_voice_reset(struct wire *wire, int i)
{
	struct wire_voice *const voice = &wire->voices[i];

	buffer_consume(&voice->held, buffer_length(&voice->held));
	voice->rest = 0;
	take_turns(wire);
}

void wire_voices_expire(struct wire *wire)
{
	for (int i = 0; i < WIRE_VOICES; i++) {
		if (is_over(&wire->voices[i])) {
			wire->voices[i].rest = 0;
		}
	}
	take_turns(wire);
}

uint64_t wire_voices_hold_us(const struct wire *wire)
{
	const uint64_t now_us = clock_board_us();
	uint64_t hold_us = 0;

	for (int i = 0; i < WIRE_VOICES; i++) {
		const struct wire_voice *const voice = &wire->voices[i];
		const uint64_t since_us = now_us - voice->heard_us;
		uint64_t left_us;

		if (buffer_length(&voice->held) == 0 && voice->rest == 0) {
			continue;
		}
		left_us = since_us < WIRE_HOLD_US ? WIRE_HOLD_US - since_us : 1;
		if (hold_us == 0 || left_us < hold_us) {
			hold_us = left_us;
		}
	}
	return hold_us;
}

void wire_voices_free(struct wire *wire)
{
	for (int i = 0; i < WIRE_VOICES; i++) {
		buffer_free(&wire->voices[i].held);
		wire->voices[i].rest = 0;
	}
}

/* --- places ----------------------------------------------------------------------------------- */

int wire_peer_find(const struct wire *wire, const struct sockaddr_storage *address)
{
	for (int i = 0; i < WIRE_PEERS_MAX; i++) {
		if (wire->kept.peers[i].present &&
		    address_equal(&wire->kept.peers[i].address, address)) {
			return i;
		}
	}
	return -1;
}

bool wire_peer_is_message(const struct wire *wire, const uint8_t *data, size_t length)
{
	if (length == 0 || wire->framing == WIRE_FRAMING_NONE) {
		return length > 0;
	}
	const size_t message = message_length(wire, data, length);

	return message > 0 && message <= length;
}

/* Places that the host of that address has. */
static int places_of(const struct wire *wire, const struct sockaddr_storage *address)
{
	int count = 0;

	for (int i = 0; i < WIRE_PEERS_MAX; i++) {
		count += wire->kept.peers[i].present &&
		         address_same_host(&wire->kept.peers[i].address, address);
	}
	return count;
}

/* Why the place may be taken, the best reason being the highest; 0: it may not. */
static int reason(const struct wire *wire, int i, const struct sockaddr_storage *address,
                  bool spoke, bool connected)
{
	const struct wire_peer *const peer = &wire->kept.peers[i];
	const uint64_t now_us = clock_board_us();
	const uint64_t silent_us = now_us - peer->heard_us;

	if (!peer->present) {
		return 4;
	}
	/* who has just connected had no time to say anything yet */
	if (!peer->spoke &&
	    (spoke || !connected || now_us - peer->since_us >= WIRE_PEER_GRACE_US)) {
		return 3;
	}
	if (silent_us >= WIRE_PEER_TIMEOUT_US || (spoke && silent_us >= WIRE_PEER_IDLE_US)) {
		return 2;
	}
	return (spoke || connected) && places_of(wire, &peer->address) > WIRE_PEERS_MAX / 2 &&
	                       places_of(wire, address) < WIRE_PEERS_MAX / 2
	               ? 1
	               : 0;
}

int wire_peer_place(struct wire *wire, const struct sockaddr_storage *address, bool spoke,
                    bool connected, int *gone)
{
	const uint64_t now_us = clock_board_us();
	int best = -1;
	int why = 0;

	for (int i = 0; i < WIRE_PEERS_MAX; i++) {
		const int its = reason(wire, i, address, spoke, connected);

		if (its > why || (its == why && its > 0 &&
		                  wire->kept.peers[i].heard_us < wire->kept.peers[best].heard_us)) {
			best = i;
			why = its;
		}
	}
	*gone = -1;
	if (best < 0) {
		return -1;
	}
	if (wire->kept.peers[best].present) {
		*gone = best;
		wire->leave(wire, best);
	}
	wire->kept.peers[best] = (struct wire_peer){
		.address = *address,
		.since_us = now_us,
		.heard_us = now_us,
		.present = true,
		.spoke = spoke,
	};
	return best;
}
