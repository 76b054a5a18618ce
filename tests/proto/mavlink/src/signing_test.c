/* SPDX-License-Identifier: Apache-2.0 */
/* Signing: what each attack gets, timestamps, streams, storing, SETUP_SIGNING. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"
#include "vectors/signing_frames.h"

#define TICKS_PER_S UINT64_C(100000) /* mavlink.io: units of 10 µs */

static struct mavlink_signing_record record;

static void before(void *unused)
{
	fixture_before(unused);
	memcpy(record.key, SIGNING_KEY, sizeof(record.key));
	record.timestamp = SIGNING_LAST - TICKS_PER_S;
	mavlink_endpoint_restore_key(&endpoint, now_us, &record);
}

ZTEST_SUITE(mavlink_signing, NULL, NULL, before, NULL, NULL);

static uint32_t verdicts(enum mavlink_signing_verdict verdict)
{
	return endpoint.signing.stats.verdicts[verdict];
}

static uint32_t all_verdicts(void)
{
	uint32_t sum = 0;

	for (int i = 0; i < MAVLINK_SIGNING_VERDICTS; i++) {
		sum += endpoint.signing.stats.verdicts[i];
	}
	return sum;
}

/* Bytes through a framer, as they come over a wire. How many frames the endpoint was given. */
static unsigned int arrive(const uint8_t *bytes, size_t length)
{
	struct mavlink_framer framer;
	struct mavlink_frame frame;
	unsigned int frames = 0;

	mavlink_framer_init(&framer);
	mavlink_outbox_clear(&out);
	zassert_equal(mavlink_framer_write(&framer, bytes, length), length);
	while (mavlink_framer_next(&framer, &frame) || mavlink_framer_idle(&framer, &frame)) {
		receive(0, frame.bytes, frame.length);
		frames++;
	}
	return frames;
}

/* A frame of the sender, signed with the key at a timestamp, as the light itself would sign. */
static size_t sign(uint8_t *bytes, const struct mavlink_kind *kind, const void *payload,
                   uint8_t component, uint8_t link_id, uint64_t timestamp)
{
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 255, .component_id = component, .has_signature = true};
	const size_t length = mavlink_frame_build(bytes, &sender, kind, payload);
	struct mavlink_signing peer;
	struct mavlink_signing_record its = record;

	its.timestamp = timestamp - 1;
	mavlink_signing_init(&peer, 0, &its);
	return length + mavlink_signing_sign(&peer, 0, bytes, length, link_id);
}

/* A signed heartbeat arrives; whether it was accepted. */
static bool hear(uint8_t component, uint8_t link_id, uint64_t timestamp)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const mavlink_heartbeat_t heartbeat = {.type = MAV_TYPE_GCS, .autopilot = 8};
	const uint32_t so_far = verdicts(MAVLINK_SIGNING_ACCEPTED);
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(0, bytes, sign(bytes, &kind, &heartbeat, component, link_id, timestamp));
	return verdicts(MAVLINK_SIGNING_ACCEPTED) == so_far + 1;
}

/* SETUP_SIGNING, signed with the key of record. */
static void set_up(uint8_t link, uint8_t system, uint8_t component,
                   const struct mavlink_signing_record *key)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(SETUP_SIGNING);
	const uint64_t now = mavlink_signing_timestamp(&endpoint.signing, now_us);
	mavlink_setup_signing_t setup = {
		.initial_timestamp = key->timestamp,
		.target_system = system,
		.target_component = component,
	};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	memcpy(setup.secret_key, key->key, sizeof(setup.secret_key));
	receive(link, bytes, sign(bytes, &kind, &setup, 190, 0, now + 1));
}

/* The same, unsigned. */
static void set_up_unsigned(uint8_t link, const struct mavlink_signing_record *key)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(SETUP_SIGNING);
	mavlink_setup_signing_t setup = {
		.initial_timestamp = key->timestamp,
		.target_system = 1,
		.target_component = 243,
	};

	memcpy(setup.secret_key, key->key, sizeof(setup.secret_key));
	receive_message(link, &kind, &setup);
}

/* --- attacks ---------------------------------------------------------------------------------- */

ZTEST(mavlink_signing, test_every_attack_gets_what_the_table_says)
{
	for (size_t i = 0; i < ARRAY_SIZE(SIGNING_ATTACKS); i++) {
		const struct signing_attack *const attack = &SIGNING_ATTACKS[i];

		before(NULL);
		zassert_equal(arrive(SIGNING_RECORDED, sizeof(SIGNING_RECORDED)), 1);
		zassert_equal(verdicts(MAVLINK_SIGNING_ACCEPTED), 1);
		zassert_equal(out.command, 405, "the recorded command was not carried out");

		const struct mavlink_signing_stats so_far = endpoint.signing.stats;
		const bool whole = attack->counter[0] != '\0';

		zassert_equal(arrive(attack->bytes, attack->length), whole ? 1 : 0, "%s",
		              attack->name);
		zassert_equal(out.command == 405, attack->acted, "%s", attack->name);
		zassert_equal(out.count, attack->acted ? 1 : 0, "%s", attack->name);
		for (int v = 0; v < MAVLINK_SIGNING_VERDICTS; v++) {
			const bool its =
				strcmp(attack->counter, mavlink_signing_verdict_name(v)) == 0;

			zassert_equal(endpoint.signing.stats.verdicts[v],
			              so_far.verdicts[v] + (its ? 1 : 0), "%s: %s", attack->name,
			              mavlink_signing_verdict_name(v));
		}
	}
}

ZTEST(mavlink_signing, test_no_flipped_bit_passes)
{
	uint8_t bytes[sizeof(SIGNING_RECORDED)];

	for (size_t bit = 0; bit < sizeof(bytes) * 8; bit++) {
		memcpy(bytes, SIGNING_RECORDED, sizeof(bytes));
		bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
		receive(0, bytes, sizeof(bytes)); /* as if its checksum were right */
		zassert_equal(out.count, 0, "bit %u", (unsigned int)bit);
		zassert_equal(out.command, 0);
	}
	zassert_equal(verdicts(MAVLINK_SIGNING_ACCEPTED), 0);
}

ZTEST(mavlink_signing, test_no_cut_passes_and_none_costs_the_next_frame)
{
	static uint8_t bytes[2 * sizeof(SIGNING_RECORDED)];

	for (size_t kept = 0; kept < sizeof(SIGNING_RECORDED); kept++) {
		before(NULL);
		memcpy(bytes, SIGNING_0, kept);
		memcpy(bytes + kept, SIGNING_RECORDED, sizeof(SIGNING_RECORDED));
		arrive(bytes, kept + sizeof(SIGNING_RECORDED));
		zassert_equal(verdicts(MAVLINK_SIGNING_ACCEPTED), 1, "%u bytes",
		              (unsigned int)kept);
		zassert_equal(out.command, 405);
	}
}

ZTEST(mavlink_signing, test_without_a_key_everything_is_heard_and_nothing_is_counted)
{
	const struct mavlink_signing_record none = {0};

	mavlink_endpoint_restore_key(&endpoint, now_us, &none);
	for (size_t i = 0; i < ARRAY_SIZE(SIGNING_ATTACKS); i++) {
		if (SIGNING_ATTACKS[i].counter[0] != '\0') {
			zassert_equal(arrive(SIGNING_ATTACKS[i].bytes, SIGNING_ATTACKS[i].length),
			              1);
		}
	}
	zassert_equal(arrive(COMMAND_ON_V2, sizeof(COMMAND_ON_V2)), 1);
	zassert_equal(out.command, 405);
	zassert_false(sent(0).has_signature);
	zassert_equal(all_verdicts(), 0);
	zassert_equal(endpoint.signing.stats.signed_frames, 0);
}

ZTEST(mavlink_signing, test_a_replay_on_another_wire_is_a_replay)
{
	receive(0, SIGNING_RECORDED, sizeof(SIGNING_RECORDED));
	zassert_equal(out.command, 405);
	receive(1, SIGNING_RECORDED, sizeof(SIGNING_RECORDED));
	zassert_equal(out.command, 0);
	zassert_equal(verdicts(MAVLINK_SIGNING_REPLAYED), 1);
}

/* --- what goes out ---------------------------------------------------------------------------- */

ZTEST(mavlink_signing, test_signature_is_pymavlinks_to_the_byte)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const mavlink_heartbeat_t heartbeat = {
		.type = 6, .autopilot = 8, .system_status = 4, .mavlink_version = 3};
	const struct mavlink_sender sender = {.version = 2,
	                                      .sequence = 3,
	                                      .system_id = 255,
	                                      .component_id = 190,
	                                      .has_signature = true};
	struct mavlink_signing signing;
	uint8_t bytes[MAVLINK_FRAME_MAX];
	size_t length = mavlink_frame_build(bytes, &sender, &kind, &heartbeat);

	/* Each frame takes the next timestamp: 0x0123456789AB is the vector's. */
	record.timestamp = 0x0123456789AA;
	mavlink_signing_init(&signing, 0, &record);
	length += mavlink_signing_sign(&signing, 0, bytes, length, 1);
	zassert_equal(length, sizeof(HEARTBEAT_SIGNED));
	zassert_mem_equal(bytes, HEARTBEAT_SIGNED, length);
}

static void check_signatures(uint64_t last[2], unsigned int sent_on[2])
{
	for (uint16_t i = 0; i < out.count; i++) {
		const struct mavlink_frame frame = sent(i);
		const uint8_t *const signature = frame.bytes + frame.length - 13;
		const uint8_t link = out.frames[i].link;
		uint64_t timestamp = 0;

		zassert_true(frame.has_signature);
		zassert_equal(signature[0], link);
		memcpy(&timestamp, signature + 1, 6);
		zassert_true(timestamp > last[link], "it does not rise");
		last[link] = timestamp;
		sent_on[link]++;
	}
}

ZTEST(mavlink_signing, test_everything_goes_out_signed_with_the_links_id_and_a_rising_timestamp)
{
	uint64_t last[2] = {0, 0};
	unsigned int sent_on[2] = {0, 0};

	for (int second = 0; second < 3; second++) {
		now_us = second * SECOND;
		while (mavlink_endpoint_deadline_us(&endpoint) <= now_us) {
			mavlink_endpoint_step(&endpoint, now_us, &out);
			check_signatures(last, sent_on);
		}
	}
	zassert_true(sent_on[0] >= 6 && sent_on[1] >= 6);
	zassert_equal(endpoint.signing.stats.signed_frames, sent_on[0] + sent_on[1]);
	/* Two seconds have passed, and each frame took a timestamp of its own. */
	zassert_true(last[1] >= record.timestamp + 2 * TICKS_PER_S);
	zassert_true(last[1] <= record.timestamp + 2 * TICKS_PER_S + sent_on[0] + sent_on[1]);
}

ZTEST(mavlink_signing, test_with_a_key_a_link_that_spoke_version_1_is_spoken_to_in_2)
{
	arrive(COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(verdicts(MAVLINK_SIGNING_UNSIGNED), 1);
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_true(out.count > 0);
	for (uint16_t i = 0; i < out.count; i++) {
		zassert_equal(sent(i).version, 2);
		zassert_true(sent(i).has_signature);
	}
}

/* --- timestamps ------------------------------------------------------------------------------- */

ZTEST(mavlink_signing, test_local_timestamp_runs_and_follows_what_is_accepted)
{
	const uint64_t begin = record.timestamp;

	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, 10 * SECOND),
	              begin + 10 * TICKS_PER_S);
	now_us = SECOND;
	zassert_true(hear(190, 0, begin + 3600 * TICKS_PER_S));
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us),
	              begin + 3600 * TICKS_PER_S);
	/* What is behind does not turn it back. */
	zassert_true(hear(191, 0, begin + 3590 * TICKS_PER_S));
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us),
	              begin + 3600 * TICKS_PER_S);
}

ZTEST(mavlink_signing, test_a_minute_behind_is_heard_and_more_is_not)
{
	const uint64_t now = record.timestamp;

	zassert_true(hear(1, 0, now - 6000000));
	zassert_false(hear(2, 0, now - 6000001));
	zassert_equal(verdicts(MAVLINK_SIGNING_OLD), 1);
	/* Also of a stream that is known: it was newer than its last, but it came too late. */
	now_us = 30 * SECOND;
	zassert_false(hear(1, 0, now - 6000000 + 1));
	zassert_equal(verdicts(MAVLINK_SIGNING_OLD), 2);
}

ZTEST(mavlink_signing, test_the_last_timestamp_of_all_stands_still_until_a_new_key)
{
	const uint64_t last = (UINT64_C(1) << 48) - 1;
	struct mavlink_signing_record fresh = record;

	zassert_true(hear(190, 0, last));
	now_us = 100 * SECOND;
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us), last);
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us), last);
	fresh.key[0] ^= 1;
	mavlink_endpoint_set_key(&endpoint, now_us, &fresh);
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us), record.timestamp);
}

/* --- streams ---------------------------------------------------------------------------------- */

ZTEST(mavlink_signing, test_a_full_table_refuses_new_streams_until_one_is_a_minute_behind)
{
	const uint64_t begin = record.timestamp;

	for (uint8_t i = 0; i < MAVLINK_SIGNING_STREAMS_MAX; i++) {
		zassert_true(hear(100, i, begin + i));
	}
	zassert_false(hear(100, 200, begin + 1000));
	zassert_equal(verdicts(MAVLINK_SIGNING_NO_ROOM), 1);

	/* After a minute all but the first have spoken again; its place is free to take. */
	now_us = 61 * SECOND;
	for (uint8_t i = 1; i < MAVLINK_SIGNING_STREAMS_MAX; i++) {
		zassert_true(hear(100, i, begin + 61 * TICKS_PER_S + i));
	}
	zassert_true(hear(100, 200, begin + 61 * TICKS_PER_S + 1000));
	/* Nothing of the forgotten stream can be repeated. */
	zassert_false(hear(100, 0, begin));
	zassert_equal(verdicts(MAVLINK_SIGNING_OLD), 1);
}

ZTEST(mavlink_signing, test_streams_are_told_apart_by_system_component_and_link_id)
{
	const uint64_t now = record.timestamp;

	zassert_true(hear(1, 0, now));
	zassert_true(hear(2, 0, now));
	zassert_true(hear(1, 1, now));
	zassert_false(hear(1, 0, now));
	zassert_false(hear(2, 0, now));
	zassert_false(hear(1, 1, now));
	zassert_equal(verdicts(MAVLINK_SIGNING_REPLAYED), 3);
}

/* --- what is stored --------------------------------------------------------------------------- */

ZTEST(mavlink_signing, test_timestamp_is_stored_at_least_once_a_minute)
{
	uint64_t stored = record.timestamp;
	unsigned int stores = 0;

	while (mavlink_endpoint_deadline_us(&endpoint) <= 600 * SECOND) {
		const int64_t due_us = mavlink_endpoint_deadline_us(&endpoint);

		now_us = due_us > now_us ? due_us : now_us;
		mavlink_endpoint_step(&endpoint, now_us, &out);
		if (out.store_signing) {
			zassert_mem_equal(out.signing.key, SIGNING_KEY, sizeof(out.signing.key));
			zassert_true(out.signing.timestamp <= stored + 60 * TICKS_PER_S);
			stored = out.signing.timestamp;
			stores++;
		}
	}
	zassert_true(stores >= 10 && stores <= 13, "%u in 10 minutes", stores);
}

ZTEST(mavlink_signing, test_a_leap_of_the_timestamp_is_stored_at_once)
{
	zassert_true(hear(190, 0, record.timestamp + 3600 * TICKS_PER_S));
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_true(out.store_signing);
	zassert_equal(out.signing.timestamp, record.timestamp + 3600 * TICKS_PER_S);
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_false(out.store_signing);
}

ZTEST(mavlink_signing, test_a_key_that_comes_or_goes_is_stored_at_once)
{
	struct mavlink_signing_record next = {.timestamp = 77};

	next.key[31] = 1;
	mavlink_endpoint_set_key(&endpoint, now_us, &next);
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_true(out.store_signing);
	zassert_mem_equal(&out.signing, &next, sizeof(next));
	memset(&next, 0, sizeof(next));
	mavlink_endpoint_set_key(&endpoint, now_us, &next);
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_true(out.store_signing);
	zassert_mem_equal(out.signing.key, next.key, sizeof(next.key));
	/* Off: nothing more to store. */
	now_us = 600 * SECOND;
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_false(out.store_signing);
}

/* --- SETUP_SIGNING ---------------------------------------------------------------------------- */

static const struct mavlink_signing_record another = {
	.timestamp = UINT64_C(40000000000000),
	.key = {0xAA, 0xBB},
};

ZTEST(mavlink_signing, test_setup_is_refused_on_a_link_that_is_not_secure)
{
	mavlink_endpoint_set_secure_links(&endpoint, 0x02);
	set_up(0, 1, 243, &another);
	zassert_equal(endpoint.signing.stats.setups_refused, 1);
	zassert_equal(endpoint.signing.stats.setups, 0);
	zassert_mem_equal(endpoint.signing.now.key, SIGNING_KEY, sizeof(SIGNING_KEY));
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_signing, test_setup_is_refused_unless_it_is_addressed_to_us)
{
	static const uint8_t targets[][2] = {{0, 0}, {0, 243}, {1, 0}, {1, 1}, {2, 243}};

	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	for (size_t i = 0; i < ARRAY_SIZE(targets); i++) {
		set_up(0, targets[i][0], targets[i][1], &another);
	}
	zassert_equal(endpoint.signing.stats.setups_refused, ARRAY_SIZE(targets));
	zassert_mem_equal(endpoint.signing.now.key, SIGNING_KEY, sizeof(SIGNING_KEY));
}

ZTEST(mavlink_signing, test_setup_on_a_secure_link_sets_key_and_timestamp_and_is_told)
{
	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	set_up(0, 1, 243, &another);
	zassert_equal(endpoint.signing.stats.setups, 1);
	zassert_mem_equal(endpoint.signing.now.key, another.key, sizeof(another.key));
	zassert_equal(mavlink_signing_timestamp(&endpoint.signing, now_us), another.timestamp);
	zassert_equal(verdicts(MAVLINK_SIGNING_ACCEPTED), 1);
	zassert_equal(all_verdicts(), 1);

	const struct tally tally = run_until(SECOND / 2);

	zassert_equal(tally.texts[0], 1);
	zassert_equal(strcmp(tally.last_text.text, "MAVLink signing: a key is set"), 0);
}

ZTEST(mavlink_signing, test_setup_with_a_key_of_zeros_turns_signing_off)
{
	const struct mavlink_signing_record none = {0};

	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	set_up(0, 1, 243, &none);
	zassert_equal(arrive(COMMAND_ON_V2, sizeof(COMMAND_ON_V2)), 1);
	zassert_equal(out.command, 405);
	zassert_false(sent(0).has_signature);
}

ZTEST(mavlink_signing, test_setup_without_a_signature_changes_no_key)
{
	const struct mavlink_signing_record none = {0};

	mavlink_endpoint_set_secure_links(&endpoint, 0xFF);
	set_up_unsigned(0, &none);
	set_up_unsigned(0, &another);
	zassert_equal(endpoint.signing.stats.setups, 0);
	zassert_equal(endpoint.signing.stats.setups_refused, 2);
	zassert_equal(verdicts(MAVLINK_SIGNING_UNSIGNED), 2);
	zassert_mem_equal(endpoint.signing.now.key, SIGNING_KEY, sizeof(SIGNING_KEY));
}

ZTEST(mavlink_signing, test_the_first_key_needs_no_signature)
{
	const struct mavlink_signing_record none = {0};

	mavlink_endpoint_set_key(&endpoint, now_us, &none);
	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	set_up_unsigned(1, &another);
	zassert_false(endpoint.signing.on, "the second link is not secure");
	set_up_unsigned(0, &another);
	zassert_mem_equal(endpoint.signing.now.key, another.key, sizeof(another.key));
}

ZTEST(mavlink_signing, test_a_new_key_knows_none_of_the_old_streams)
{
	zassert_true(hear(190, 0, record.timestamp + 2));
	zassert_equal(endpoint.signing.stream_count, 1);
	mavlink_endpoint_set_key(&endpoint, now_us, &another);
	zassert_equal(endpoint.signing.stream_count, 0);
	record = another;
	zassert_true(hear(190, 0, another.timestamp + 1), "older than the old key's last");
}

ZTEST(mavlink_signing, test_setup_that_is_wrongly_signed_is_refused_even_on_a_secure_link)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(SETUP_SIGNING);
	const mavlink_setup_signing_t setup = {
		.secret_key = {1}, .target_system = 1, .target_component = 243};
	uint8_t bytes[MAVLINK_FRAME_MAX];
	const size_t length = sign(bytes, &kind, &setup, 190, 0, record.timestamp);

	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	bytes[length - 1] ^= 1;
	receive(0, bytes, length);
	zassert_equal(endpoint.signing.stats.setups_refused, 1);
	bytes[length - 1] ^= 1;
	receive(0, bytes, length);
	zassert_equal(endpoint.signing.stats.setups, 1);
}

ZTEST(mavlink_signing, test_the_same_key_again_makes_no_recording_good)
{
	receive(0, SIGNING_RECORDED, sizeof(SIGNING_RECORDED));
	mavlink_endpoint_set_secure_links(&endpoint, 0x01);
	record.timestamp = 0;
	set_up(0, 1, 243, &record);
	zassert_equal(endpoint.signing.stats.setups, 1);
	receive(0, SIGNING_RECORDED, sizeof(SIGNING_RECORDED));
	zassert_equal(verdicts(MAVLINK_SIGNING_REPLAYED), 1);
	zassert_true(mavlink_signing_timestamp(&endpoint.signing, now_us) >= SIGNING_LAST);
}
