/* SPDX-License-Identifier: Apache-2.0 */
/*
 * External sync: the gate follows an input, or each active edge of it gives a pulse.
 *
 * Glitch filter: a change of the input counts once it has lasted filter_us; it counts at the
 * instant when that time is over (a delay, no jitter). A shorter change never happened.
 * LEVEL: the gate is the filtered input. EDGE: each filtered change to active gives a pulse of
 * pulse_us; while it lasts a further one is dropped (IGNORE) or prolongs it to its own end
 * (EXTEND). Time-out: timeout_us after the last filtered change (or the start) the policy takes
 * over: OFF, ON (steady), INTERNAL (the strobe of the plan); until the next filtered change. 0:
 * never.
 *
 * Timestamps are arguments, so an input may be told late, with its own time; one older than what
 * was already decided counts as now and is counted. Context: thread or interrupt, serialised by the
 * caller. Spec: MAVLink common 406, external sync.
 */
#ifndef PHAROS_CORE_SYNC_H
#define PHAROS_CORE_SYNC_H

#include <stdbool.h>
#include <stdint.h>

enum sync_mode {
	SYNC_MODE_LEVEL,
	SYNC_MODE_EDGE,
};

enum sync_polarity {
	SYNC_ACTIVE_HIGH,
	SYNC_ACTIVE_LOW,
};

enum sync_retrigger {
	SYNC_RETRIGGER_IGNORE,
	SYNC_RETRIGGER_EXTEND,
};

enum sync_policy {
	SYNC_POLICY_OFF,
	SYNC_POLICY_ON,
	SYNC_POLICY_INTERNAL,
};

/* pulse_us >= 1 (asserted). timeout_us 0: never. */
struct sync_config {
	enum sync_mode mode;
	enum sync_polarity polarity;
	enum sync_retrigger retrigger;
	enum sync_policy policy;
	uint32_t filter_us;
	uint32_t pulse_us;
	uint32_t timeout_us;
};

enum sync_output {
	SYNC_OUTPUT_DARK,
	SYNC_OUTPUT_LIT,
	SYNC_OUTPUT_INTERNAL, /* the internal strobe has the gate */
};

struct sync_stats {
	uint32_t changes;  /* filtered */
	uint32_t glitches; /* dropped by the filter */
	uint32_t pulses;
	uint32_t ignored; /* edges dropped by IGNORE */
	uint32_t timeouts;
	uint32_t late; /* timestamps older than what was decided */
};

struct sync {
	struct sync_config config;
	struct sync_stats stats;
	int64_t now_us;      /* up to when everything is decided */
	int64_t pending_us;  /* when the unfiltered change came */
	int64_t activity_us; /* last filtered change, or start */
	int64_t pulse_end_us;
	bool pending; /* the input differs from the filtered level */
	bool active;  /* filtered */
	bool timed_out;
};

/* level: the input as it is now (raw, before polarity); it counts as filtered but as no edge. */
void sync_init(struct sync *self, int64_t now_us, const struct sync_config *config, bool level);

/* New parameters: as sync_init, the counters stay. */
void sync_configure(struct sync *self, int64_t now_us, const struct sync_config *config,
                    bool level);

/* The raw input has been level since at_us (0…TIME_MAX_US). Repeats are harmless. */
void sync_input(struct sync *self, int64_t at_us, bool level);

/* Decides everything up to now_us; returns the output from now_us on. */
enum sync_output sync_advance(struct sync *self, int64_t now_us);

/* When the output may next change by itself; TIME_NEVER_US: only with an input. */
int64_t sync_deadline_us(const struct sync *self);

#endif
