/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MAVLink FTP by the frame. Opcodes and errors are numbers of mavlink.io/en/services/ftp.html;
 * where a payload's fields lie too: sequence 0, session 2, opcode 3, size 4, request 5, burst
 * complete 6, offset 8, data 12.
 */
#include "fixture.h"

#define FILES       12
#define NAME_FORMAT "a-file-with-a-rather-long-nam-"

static uint8_t content[1000];
static struct mavlink_file served[FILES];
static char names[FILES][33];
static const struct mavlink_files files = {served, FILES};

/* File 0 is empty, file 1 has all of content, the others a byte. */
static void before(void *unused)
{
	fixture_before(unused);
	memset(content, 0x55, sizeof(content)); /* zeros would be truncated on the wire */
	for (uint8_t i = 0; i < FILES; i++) {
		memcpy(names[i], NAME_FORMAT, sizeof(NAME_FORMAT));
		names[i][sizeof(NAME_FORMAT) - 1] = (char)('a' + i);
		served[i] = (struct mavlink_file){names[i], content, 1, 0xA0000000u + i};
	}
	served[0].length = 0;
	served[1].length = sizeof(content);
	mavlink_ftp_init(&service.ftp, &files, &service.params);
}

ZTEST_SUITE(mavlink_ftp, NULL, NULL, before, NULL, NULL);

struct ask {
	uint16_t sequence;
	uint8_t session;
	uint8_t opcode;
	uint8_t size;
	uint32_t offset;
	const char *path;
};

static void send(uint8_t link, struct ask ask)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(FILE_TRANSFER_PROTOCOL);
	mavlink_file_transfer_protocol_t wire = {.target_system = 1, .target_component = 243};

	memcpy(&wire.payload[0], &ask.sequence, 2);
	wire.payload[2] = ask.session;
	wire.payload[3] = ask.opcode;
	wire.payload[4] = ask.path != NULL ? (uint8_t)strlen(ask.path) : ask.size;
	memcpy(&wire.payload[8], &ask.offset, 4);
	if (ask.path != NULL) {
		memcpy(&wire.payload[12], ask.path, strlen(ask.path));
	}
	receive_message(link, &kind, &wire);
}

/* The payload of frame i of the outbox. */
static const uint8_t *reply(uint16_t i)
{
	static mavlink_file_transfer_protocol_t wire;

	sent_payload(i, 110, &wire, sizeof(wire));
	zassert_equal(wire.target_system, 255);
	zassert_equal(wire.target_component, 190);
	return wire.payload;
}

static const uint8_t *asked(struct ask ask)
{
	send(0, ask);
	zassert_equal(out.count, 1);
	return reply(0);
}

static void assert_error(const uint8_t *payload, uint8_t error)
{
	zassert_equal(payload[3], 129, "acknowledged");
	zassert_equal(payload[4], 1);
	zassert_equal(payload[12], error, "error %u, not %u", payload[12], error);
}

static void assert_ok(const uint8_t *payload)
{
	zassert_equal(payload[3], 128, "error %u", payload[12]);
}

static uint8_t opened(uint16_t sequence, uint8_t file)
{
	const uint8_t *const payload =
		asked((struct ask){.sequence = sequence, .opcode = 4, .path = names[file]});

	assert_ok(payload);
	return payload[2];
}

ZTEST(mavlink_ftp, test_every_field_of_an_answer)
{
	static const uint8_t expected[] = {0x35, 0x12, 0, 128, 4,    4,    0, 0,
	                                   0,    0,    0, 0,   0xE8, 0x03, 0, 0};

	zassert_mem_equal(asked((struct ask){.sequence = 0x1234, .opcode = 4, .path = names[1]}),
	                  expected, sizeof(expected));
}

ZTEST(mavlink_ftp, test_listing_goes_on_where_an_answer_was_full)
{
	uint32_t found = 0;
	uint8_t answers = 0;

	for (;;) {
		const uint8_t *const payload =
			asked((struct ask){.opcode = 3, .offset = found, .path = "/"});

		if (payload[3] == 129) {
			assert_error(payload, 6);
			break;
		}
		for (uint8_t at = 0; at < payload[4];) {
			const char *const entry = (const char *)&payload[12 + at];

			zassert_equal(entry[0], 'F');
			zassert_mem_equal(&entry[1], names[found], strlen(names[found]));
			zassert_equal(entry[1 + strlen(names[found])], '\t');
			zassert_equal(strcmp(&entry[2 + strlen(names[found])], found == 0   ? "0"
			                                                       : found == 1 ? "1000"
			                                                                    : "1"),
			              0);
			at = (uint8_t)(at + strlen(entry) + 1);
			found++;
		}
		answers++;
	}
	zassert_equal(found, FILES);
	/* 35 bytes each, 38 the one of 1000; the sixth is sure to fit into 239, the seventh isn't
	 */
	zassert_equal(answers, 2);
}

ZTEST(mavlink_ftp, test_an_empty_file_ends_at_once)
{
	const uint8_t session = opened(0, 0);

	assert_error(asked((struct ask){.session = session, .opcode = 5, .size = 9}), 6);
	assert_error(asked((struct ask){.session = session, .opcode = 15, .size = 9}), 6);
}

ZTEST(mavlink_ftp, test_checksum_is_the_files_own)
{
	static const uint8_t crc[] = {0x0B, 0, 0, 0xA0};
	const uint8_t *const payload = asked((struct ask){.opcode = 14, .path = names[11]});

	zassert_equal(payload[4], 4);
	zassert_mem_equal(&payload[12], crc, sizeof(crc));
}

/* Frames of FTP sent from now until then. */
static uint32_t parts_until(int64_t until_us)
{
	return run_until(until_us).others[0];
}

ZTEST(mavlink_ftp, test_a_burst_ends_when_its_link_goes)
{
	(void)run_until(SECOND);
	send(0, (struct ask){.session = opened(0, 1), .opcode = 15, .size = 10});
	zassert_true(parts_until(now_us + SECOND / 2) >= 1);
	mavlink_endpoint_link_down(&endpoint, 0);
	zassert_equal(parts_until(now_us + 10 * SECOND), 0);
	mavlink_endpoint_link_up(&endpoint, now_us, 0);
	zassert_equal(parts_until(now_us + 10 * SECOND), 0);
}

ZTEST(mavlink_ftp, test_a_burst_goes_on_after_a_full_outbox)
{
	struct mavlink_context context = {
		.endpoint = &endpoint, .component = &endpoint.components[0], .out = &out};

	(void)run_until(SECOND);
	send(0, (struct ask){.session = opened(0, 1), .opcode = 15, .size = 239});
	context.now_us = now_us;
	out.count = MAVLINK_OUTBOX_FRAMES;
	zassert_false(mavlink_ftp_step(&service.ftp, &context));
	zassert_true(mavlink_ftp_deadline_us(&service.ftp) <= now_us, "it is still due");
	zassert_equal(parts_until(now_us + 5 * SECOND), 5, "1000 bytes in parts of 239");
	zassert_equal(mavlink_ftp_deadline_us(&service.ftp), TIME_NEVER_US);
}

ZTEST(mavlink_ftp, test_two_bursts_on_one_link_share_its_pace)
{
	(void)run_until(SECOND);

	const uint8_t one = opened(0, 1);
	const uint8_t two = opened(2, 1);

	send(0, (struct ask){.session = one, .opcode = 15, .size = 239});
	send(0, (struct ask){.session = two, .opcode = 15, .size = 239});

	const int64_t begin_us = now_us;
	uint32_t parts = 0;

	while (parts < 10) {
		parts += parts_until(now_us + 1000);
	}
	/*
	 * 5760 bytes a second, 46 % of them for bulk; 2 x (4 frames of 266 bytes and one of 71);
	 * the first goes at once, and the last need not be waited for
	 */
	const int64_t least_us = (int64_t)(2 * (4 * 266 + 71) - 266) * 1000000 * 100 / (5760 * 46);

	zassert_true(now_us - begin_us >= least_us, "%d us", (int)(now_us - begin_us));
	zassert_true(now_us - begin_us <= least_us * 11 / 10, "%d us", (int)(now_us - begin_us));
}

/* MAVProxy chooses a number and drops answers with another one. */
ZTEST(mavlink_ftp, test_the_clients_number_is_taken)
{
	const uint8_t *payload;

	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		const uint8_t wanted = (uint8_t)(69 + 60 * i);

		/* two sessions may well begin with the same sequence number and file */
		payload = asked((struct ask){.session = wanted, .opcode = 4, .path = names[1]});
		assert_ok(payload);
		zassert_equal(payload[2], wanted);
	}
	payload = asked((struct ask){.session = 129, .opcode = 5, .size = 9});
	assert_ok(payload);
	zassert_equal(payload[2], 129);
	assert_error(asked((struct ask){.session = 0, .opcode = 5, .size = 9}), 4);
	assert_ok(asked((struct ask){.sequence = 4, .session = 129, .opcode = 1}));
	assert_ok(asked((struct ask){.sequence = 4, .session = 129, .opcode = 1}));
	assert_error(asked((struct ask){.sequence = 6, .session = 129, .opcode = 1}), 4);
	payload = asked((struct ask){.sequence = 8, .session = 129, .opcode = 4, .path = names[2]});
	assert_ok(payload);
	zassert_equal(payload[2], 129);
}

ZTEST(mavlink_ftp, test_a_number_in_use_is_not_given_twice)
{
	const struct ask open = {.session = 1, .opcode = 4, .path = names[1]};
	struct ask other = open;

	zassert_equal(asked(open)[2], 1);
	zassert_equal(asked(open)[2], 1, "the same request");
	for (uint8_t i = 0; i < 3; i++) {
		static const uint8_t lowest[] = {0, 2, 3};

		other.sequence = (uint16_t)(other.sequence + 2);
		zassert_equal(asked(other)[2], lowest[i]);
	}
}

ZTEST(mavlink_ftp, test_numbers_are_each_clients_own)
{
	const struct ask open = {.session = 69, .opcode = 4, .path = names[1]};

	send(0, open);
	zassert_equal(reply(0)[2], 69);
	send(1, open);
	zassert_equal(reply(0)[2], 69);
	send(1, (struct ask){.sequence = 2, .session = 69, .opcode = 1});
	assert_ok(reply(0));
	send(0, (struct ask){.sequence = 2, .session = 69, .opcode = 5, .size = 9});
	assert_ok(reply(0));
}

/* Another component may have the file. */
ZTEST(mavlink_ftp, test_what_all_are_asked_for_in_vain_meets_silence)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(FILE_TRANSFER_PROTOCOL);
	static const struct {
		uint8_t opcode;
		const char *path;
		uint8_t answer; /* 0: none */
	} table[] = {
		{4, "@SYS/threads.txt", 0}, /* open */
		{5, "", 0},                 /* read a session of someone else */
		{6, "new.txt", 0},          /* create */
		{42, "", 0},                /* unknown */
		{3, "/", 128},              /* list */
		{4, NAME_FORMAT "b", 128},
	};

	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		mavlink_file_transfer_protocol_t wire = {.target_system = 1};

		wire.payload[2] = 7;
		wire.payload[3] = table[i].opcode;
		wire.payload[4] = (uint8_t)strlen(table[i].path);
		memcpy(&wire.payload[12], table[i].path, strlen(table[i].path));
		receive_message(0, &kind, &wire);
		zassert_equal(out.count, table[i].answer == 0 ? 0 : 1, "row %zu", i);
		if (out.count != 0) {
			zassert_equal(reply(0)[3], table[i].answer);
		}
	}
}

#define PACK "@PARAM/param.pck"

static uint32_t values_sent(int64_t until_us)
{
	return run_until(until_us).others[0];
}

/* All of the file, in parts of 239, from a session; the values are 4 bytes before each name. */
static uint32_t read_pack(uint8_t session, uint8_t *to)
{
	uint32_t length = 0;

	for (;;) {
		const uint8_t *const payload = asked((struct ask){
			.session = session, .opcode = 5, .size = 239, .offset = length});

		if (payload[3] == 129) {
			assert_error(payload, 6);
			return length;
		}
		memcpy(to + length, &payload[12], payload[4]);
		length += payload[4];
	}
}

ZTEST(mavlink_ftp, test_packed_parameters_are_of_one_instant)
{
	static uint8_t first[4096];
	static uint8_t again[4096];
	struct param_set changed;
	uint32_t length;

	(void)run_until(SECOND);
	assert_ok(asked((struct ask){.session = 9, .opcode = 4, .path = PACK "?withdefaults=1"}));
	length = read_pack(9, first);
	zassert_equal(length, mavlink_param_pack_length(&service.ftp.pack, true));
	zassert_equal(params_set(device_params, PARAM_LGT_RESTORE, 1, &changed), PARAMS_OK);
	zassert_equal(read_pack(9, again), length);
	zassert_mem_equal(first, again, length);

	/* new ones are not to be had while someone reads the old ones */
	assert_error(asked((struct ask){.session = 8, .sequence = 2, .opcode = 4, .path = PACK}),
	             5);
	zassert_equal(values_sent(now_us + SECOND), 0);
	assert_ok(asked((struct ask){.session = 9, .sequence = 4, .opcode = 1}));
	zassert_equal(values_sent(now_us + SECOND), 1, "what the file had wrong");
	assert_ok(asked((struct ask){.session = 8, .sequence = 6, .opcode = 4, .path = PACK}));
}

static uint32_t pack_crc32(uint16_t sequence, const char *path)
{
	const uint8_t *const payload =
		asked((struct ask){.sequence = sequence, .opcode = 14, .path = path});

	assert_ok(payload);
	zassert_equal(payload[4], 4);
	return payload[12] | payload[13] << 8 | payload[14] << 16 | (uint32_t)payload[15] << 24;
}

/* Bit by bit, as mavlink.io/en/guide/crc.html has it. */
static uint32_t crc32_of(const uint8_t *bytes, uint32_t length)
{
	uint32_t crc = 0;

	for (uint32_t bit = 0; bit < 8 * length; bit++) {
		const uint32_t in = bytes[bit / 8] >> bit % 8 & 1;

		crc = (crc & 1) == in ? crc >> 1 : crc >> 1 ^ 0xEDB88320u;
	}
	return crc;
}

ZTEST(mavlink_ftp, test_checksum_of_packed_parameters_is_that_of_what_is_read)
{
	static uint8_t file[4096];
	struct param_set changed;
	uint32_t length;
	uint32_t before;

	before = pack_crc32(100, PACK);
	zassert_equal(params_set(device_params, PARAM_LGT_RESTORE, 1, &changed), PARAMS_OK);
	zassert_not_equal(pack_crc32(102, PACK), before, "it is of now");
	assert_ok(asked((struct ask){.session = 9, .opcode = 4, .path = PACK "?withdefaults=1"}));
	length = read_pack(9, file);
	zassert_equal(pack_crc32(104, PACK "?withdefaults=1"), crc32_of(file, length));
	/* and stays so while it is read */
	zassert_equal(params_set(device_params, PARAM_LGT_RESTORE, 0, &changed), PARAMS_OK);
	zassert_equal(pack_crc32(106, PACK "?withdefaults=1"), crc32_of(file, length));
}

ZTEST(mavlink_ftp, test_idle_packed_parameters_are_given_up)
{
	struct param_set changed;

	(void)run_until(SECOND);
	assert_ok(asked((struct ask){.session = 9, .opcode = 4, .path = PACK}));
	zassert_equal(params_set(device_params, PARAM_LGT_RESTORE, 1, &changed), PARAMS_OK);
	zassert_equal(values_sent(now_us + 9 * SECOND), 0);
	zassert_equal(values_sent(now_us + 2 * SECOND), 1);
	assert_error(asked((struct ask){.session = 9, .opcode = 5, .size = 9}), 4);
}

ZTEST(mavlink_ftp, test_two_clients_read_the_same_packed_parameters)
{
	struct param_set changed;

	assert_ok(asked((struct ask){.session = 9, .opcode = 4, .path = PACK}));
	assert_ok(asked((struct ask){.session = 8, .opcode = 4, .path = PACK "?withdefaults=1"}));
	zassert_equal(params_set(device_params, PARAM_LGT_RESTORE, 1, &changed), PARAMS_OK);
	assert_ok(asked((struct ask){.session = 9, .sequence = 2, .opcode = 1}));
	/* the other still does */
	assert_error(asked((struct ask){.session = 7, .sequence = 4, .opcode = 4, .path = PACK}),
	             5);
	assert_ok(asked((struct ask){.session = 8, .sequence = 6, .opcode = 2}));
	assert_ok(asked((struct ask){.session = 7, .sequence = 8, .opcode = 4, .path = PACK}));
}

ZTEST(mavlink_ftp, test_version_1_can_read_too)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(FILE_TRANSFER_PROTOCOL);
	const struct mavlink_sender ground = {.version = 1, .system_id = 255, .component_id = 190};
	const mavlink_file_transfer_protocol_t wire = {
		.target_system = 1, .target_component = 243, .payload = {[3] = 3}};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(0, bytes, mavlink_frame_build(bytes, &ground, &kind, &wire));
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).version, 1);
	zassert_equal(reply(0)[3], 128);
}

ZTEST(mavlink_ftp, test_refusals_are_counted_and_ends_are_not)
{
	(void)asked((struct ask){.opcode = 5, .session = 9, .size = 1}); /* no such session */
	(void)asked((struct ask){.opcode = 6, .path = "x"});             /* create */
	(void)asked((struct ask){.opcode = 3, .offset = 99});            /* end of the list */
	zassert_equal(service.ftp.stats.requests, 3);
	zassert_equal(service.ftp.stats.refused, 2);
}
