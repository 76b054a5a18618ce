/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several peers that share one wire (clients of tcpin:, senders to udpin:). A UART is one stream of
 * bytes, so they take turns, message by message: what one peer has said so far of a message is kept
 * here until the rest has come, and goes to the device in one piece. Where a message ends is read
 * from its length (MAVLink 1 and 2, or IMC, whichever the device speaks on that wire); whether it
 * is right is the device's business. What begins no message goes on at once, and so does what a
 * peer says while it is alone. A rest that does not come within WIRE_HOLD_US is not waited for:
 * then all that is kept goes on. Nothing is lost.
 *
 *   peer 0:  [fd 21 00 …] . . . . [… 10 fe]            device:  [fd 09 …][fd 21 00 … 10 fe]
 *   peer 1:              [fd 09 …]
 *
 * And they have WIRE_PEERS_MAX places. Another peer takes a free one; or that of one that has never
 * said a whole message; or, if it has said one itself, of one that has been silent for
 * WIRE_PEER_IDLE_US, or of an address with more than half of the places. So strangers keep nobody
 * away who is heard, and one host does not keep all others away.
 */
#ifndef NATIVE_HOST_WIRE_PEERS_H_
#define NATIVE_HOST_WIRE_PEERS_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/wire_state.h"

#define WIRE_HOLD_US         200000u
#define WIRE_PEER_IDLE_US    1500000u /* longer than a station's heartbeat */
#define WIRE_PEER_GRACE_US   2000000u /* in which a new one may say something */
#define WIRE_PEER_TIMEOUT_US 60000000u

/*
 * A place for a new peer, which is then present; -1: there is none. spoke: it has said a whole
 * message. connected: its address is its own, since it has shaken hands. *gone: whose place it was,
 * -1: it was free.
 */
int wire_peer_place(struct wire *wire, const struct sockaddr_storage *address, bool spoke,
                    bool connected, int *gone);

/* The present peer of that address; -1: none. */
int wire_peer_find(const struct wire *wire, const struct sockaddr_storage *address);

/* Is there a whole message at the beginning? */
bool wire_peer_is_message(const struct wire *wire, const uint8_t *data, size_t length);

/* --- for wire.c ------------------------------------------------------------------------------- */

/* Bytes of a voice have come to the device's end; what may go on is given to the wire. */
void wire_voice_said(struct wire *wire, int voice, const uint8_t *data, size_t length);

/* The voice is a new peer's from here on. */
void wire_voice_reset(struct wire *wire, int voice);

/* What is kept goes on where WIRE_HOLD_US are over. */
void wire_voices_expire(struct wire *wire);

/* How long until that, at most; 0: nothing is kept. */
uint64_t wire_voices_hold_us(const struct wire *wire);

/* The device has sent that: which framing it speaks. */
void wire_voices_learn(struct wire *wire, const uint8_t *data, size_t length);

void wire_voices_free(struct wire *wire);

#endif
