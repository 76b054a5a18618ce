/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A firmware image over MAVLink FTP, by the frame; the image's owner is played here. Opcodes and
 * errors are numbers of mavlink.io/en/services/ftp.html.
 */
#include "fixture.h"

#define CREATE    6
#define WRITE     7
#define TERMINATE 1
#define RESET     2
#define CRC       14
#define READ_ONLY 4
#define WRITABLE  11

#define FAIL            1
#define INVALID_SIZE    3
#define INVALID_SESSION 4
#define NO_SESSIONS     5
#define PROTECTED       9

#define ACK 128
#define NAK 129

#define LATER 0 /* no opcode of an answer */

static uint8_t image[600];
static uint16_t sequence;
static uint8_t asker; /* component id */
static mavlink_file_transfer_protocol_t answer;

static void before(void *unused)
{
	fixture_before(unused);
	device_params->values[PARAM_LGT_SRC_EXCL] = 0;
	sequence = 0;
	asker = 190;
	for (size_t i = 0; i < sizeof(image); i++) {
		image[i] = (uint8_t)(i * 7);
	}
}

ZTEST_SUITE(mavlink_upload, NULL, NULL, before, NULL, NULL);

struct ask {
	uint8_t opcode;
	uint8_t session;
	uint8_t size;
	uint32_t offset;
	const void *data;
	uint8_t component; /* 0: all; else the light */
};

/* The opcode of the answer, LATER: none came. */
static uint8_t ask_again(struct ask ask)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(FILE_TRANSFER_PROTOCOL);
	mavlink_file_transfer_protocol_t wire = {.target_system = 1,
	                                         .target_component = ask.component};
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 255, .component_id = asker};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	memcpy(&wire.payload[0], &sequence, 2);
	wire.payload[2] = ask.session;
	wire.payload[3] = ask.opcode;
	wire.payload[4] = ask.size;
	memcpy(&wire.payload[8], &ask.offset, 4);
	if (ask.data != NULL) {
		memcpy(&wire.payload[12], ask.data, ask.size);
	}
	receive(0, bytes, mavlink_frame_build(bytes, &sender, &kind, &wire));
	if (out.count == 0) {
		return LATER;
	}
	sent_payload(0, 110, &answer, sizeof(answer));
	return answer.payload[3];
}

static uint8_t ask(struct ask ask)
{
	sequence += 2;
	ask.component = 243;
	return ask_again(ask);
}

static uint8_t open_as(uint8_t opcode, const char *name)
{
	return ask((struct ask){.opcode = opcode, .size = (uint8_t)strlen(name), .data = name});
}

/* What the owner did is done; the answer that was owed. */
static uint8_t done(const char *failure)
{
	mavlink_upload_done(&service.ftp.upload, now_us, failure);
	for (;;) {
		zassert_true(mavlink_endpoint_deadline_us(&endpoint) <= now_us);
		mavlink_endpoint_step(&endpoint, now_us, &out);
		for (uint16_t i = 0; i < out.count; i++) {
			if (sent(i).message_id == 110) {
				sent_payload(i, 110, &answer, sizeof(answer));
				return answer.payload[3];
			}
		}
	}
}

static uint8_t write_at(uint32_t offset, uint8_t size)
{
	return ask((struct ask){
		.opcode = WRITE, .size = size, .offset = offset, .data = image + offset});
}

static void assert_error(uint8_t opcode, uint8_t error)
{
	zassert_equal(opcode, NAK);
	zassert_equal(answer.payload[12], error, "error %u", answer.payload[12]);
}

static void begin(void)
{
	zassert_equal(open_as(CREATE, "/firmware.bin"), LATER);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_BEGIN);
	zassert_equal(done(NULL), ACK);
	zassert_equal(answer.payload[5], CREATE);
}

static uint32_t number(void)
{
	uint32_t value;

	zassert_equal(answer.payload[4], 4);
	memcpy(&value, &answer.payload[12], sizeof(value));
	return value;
}

ZTEST(mavlink_upload, test_an_image_comes_in_blocks_and_is_answered_when_stored)
{
	begin();
	zassert_equal(write_at(0, 239), ACK);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING);
	zassert_equal(write_at(239, 239), LATER);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_BLOCK);
	zassert_mem_equal(service.ftp.upload.buffer, image, 256);
	zassert_equal(ask_again((struct ask){.opcode = WRITE,
	                                     .size = 239,
	                                     .offset = 239,
	                                     .data = image + 239,
	                                     .component = 243}),
	              LATER, "repeated meanwhile");
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING, "and done once");
	zassert_equal(done(NULL), ACK);
	zassert_equal(answer.payload[0], (uint8_t)(sequence + 1));
	zassert_equal(write_at(478, 30), ACK);
	zassert_equal(ask((struct ask){.opcode = TERMINATE}), LATER);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_LAST);
	zassert_equal(service.ftp.upload.fill, 508 - 256);
	zassert_mem_equal(service.ftp.upload.buffer, image + 256, 508 - 256);
	zassert_equal(done(NULL), ACK);
	zassert_equal(ask((struct ask){.opcode = TERMINATE}), ACK, "its answer was lost");
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING);
}

ZTEST(mavlink_upload, test_zeros_that_the_frame_left_out_are_written)
{
	memset(image, 0, sizeof(image));
	begin();
	memset(service.ftp.upload.buffer, 0xA5, sizeof(service.ftp.upload.buffer));
	zassert_equal(write_at(0, 200), ACK);
	zassert_equal(service.ftp.upload.fill, 200);
	zassert_mem_equal(service.ftp.upload.buffer, image, 200);
}

ZTEST(mavlink_upload, test_what_is_there_is_not_written_twice_and_a_gap_is_refused)
{
	begin();
	zassert_equal(write_at(0, 100), ACK);
	zassert_equal(write_at(0, 100), ACK);
	zassert_equal(service.ftp.upload.received, 100);
	zassert_equal(write_at(50, 100), ACK);
	zassert_equal(service.ftp.upload.received, 150);
	zassert_mem_equal(service.ftp.upload.buffer, image, 150);
	assert_error(write_at(151, 10), FAIL);
	assert_error(write_at(150, 0), INVALID_SIZE);
	zassert_equal(write_at(150, 10), ACK, "and it goes on");
}

ZTEST(mavlink_upload, test_who_was_away_goes_on_where_it_was)
{
	begin();
	zassert_equal(write_at(0, 100), ACK);
	now_us += 50 * SECOND;
	zassert_equal(open_as(WRITABLE, "firmware.bin"), ACK);
	zassert_equal(number(), 100);
	zassert_equal(ask((struct ask){.opcode = CRC, .size = 12, .data = "firmware.bin"}), ACK);
	/* python3: zlib.crc32(bytes(i * 7 & 255 for i in range(100)), 2**32-1) ^ 2**32-1 */
	zassert_equal(number(), 0x1B95F84Fu, "0x%08X", number());
	zassert_equal(write_at(100, 20), ACK);
}

ZTEST(mavlink_upload, test_without_anything_there_it_begins)
{
	zassert_equal(open_as(WRITABLE, "firmware.bin"), LATER);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_BEGIN);
	zassert_equal(done(NULL), ACK);
	zassert_equal(number(), 0);
}

ZTEST(mavlink_upload, test_a_new_beginning_forgets_the_old_one)
{
	begin();
	zassert_equal(write_at(0, 100), ACK);
	begin();
	zassert_equal(service.ftp.upload.received, 0);
}

ZTEST(mavlink_upload, test_silence_ends_it)
{
	begin();
	zassert_equal(write_at(0, 100), ACK);
	now_us += 60 * SECOND - 1;
	mavlink_endpoint_step(&endpoint, now_us, &out);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING);
	zassert_equal(service.ftp.upload.state, MAVLINK_UPLOAD_OPEN);
	now_us++;
	do {
		mavlink_endpoint_step(&endpoint, now_us, &out);
	} while (out.upload == MAVLINK_OUTBOX_UPLOAD_NOTHING &&
	         mavlink_endpoint_deadline_us(&endpoint) <= now_us);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_ABORT);
	assert_error(write_at(100, 100), INVALID_SESSION);
}

ZTEST(mavlink_upload, test_a_reset_ends_it_once_the_flash_is_at_rest)
{
	begin();
	zassert_equal(ask((struct ask){.opcode = RESET}), ACK);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_ABORT);
	begin();
	zassert_equal(write_at(0, 239), ACK);
	zassert_equal(write_at(239, 239), LATER);
	zassert_equal(ask((struct ask){.opcode = RESET}), ACK);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING, "the flash is at work");
	mavlink_upload_done(&service.ftp.upload, now_us, NULL);
	do {
		mavlink_endpoint_step(&endpoint, now_us, &out);
	} while (out.upload == MAVLINK_OUTBOX_UPLOAD_NOTHING &&
	         mavlink_endpoint_deadline_us(&endpoint) <= now_us);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_ABORT);
	zassert_equal(service.ftp.upload.state, MAVLINK_UPLOAD_IDLE);
}

ZTEST(mavlink_upload, test_a_failure_is_told_and_ends_it)
{
	zassert_equal(open_as(CREATE, "firmware.bin"), LATER);
	assert_error(done("the slot cannot be erased"), FAIL);
	begin();
	assert_error(write_at(0, 239) == ACK && write_at(239, 239) == LATER ? done("no image") : 0,
	             FAIL);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING);
	begin();
	zassert_equal(ask((struct ask){.opcode = TERMINATE}), LATER);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_LAST);
	assert_error(done("the image ends too early"), FAIL);
	assert_error(ask_again((struct ask){.opcode = TERMINATE, .component = 243}), FAIL);
	assert_error(ask((struct ask){.opcode = TERMINATE}), INVALID_SESSION);
}

ZTEST(mavlink_upload, test_another_client_waits_until_nobody_writes)
{
	begin();
	zassert_equal(write_at(0, 100), ACK);
	asker = 191;
	assert_error(open_as(CREATE, "firmware.bin"), NO_SESSIONS);
	assert_error(open_as(WRITABLE, "firmware.bin"), NO_SESSIONS);
	assert_error(write_at(100, 100), INVALID_SESSION);
	assert_error(ask((struct ask){.opcode = TERMINATE}), INVALID_SESSION);
	zassert_equal(ask((struct ask){.opcode = RESET}), ACK, "its own sessions");
	zassert_equal(service.ftp.upload.state, MAVLINK_UPLOAD_OPEN);
	now_us += 10 * SECOND;
	begin();
	asker = 190;
	assert_error(write_at(100, 100), INVALID_SESSION);
}

ZTEST(mavlink_upload, test_an_update_from_elsewhere_has_the_slot)
{
	service.ftp.upload.is_taken = true;
	assert_error(open_as(CREATE, "firmware.bin"), NO_SESSIONS);
	service.ftp.upload.is_taken = false;
	begin();
}

ZTEST(mavlink_upload, test_only_that_file_by_name_from_who_may)
{
	assert_error(open_as(CREATE, "other.bin"), PROTECTED);
	assert_error(open_as(CREATE, "firmware.bin2"), PROTECTED);
	assert_error(open_as(CREATE, "firmware.bim"), PROTECTED);
	assert_error(open_as(CREATE, "firmware.bio"), PROTECTED);
	assert_error(open_as(WRITABLE, "g.json"), PROTECTED);
	zassert_equal(ask_again((struct ask){.opcode = CREATE, .size = 12, .data = "firmware.bin"}),
	              LATER, "to all: silence");
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_NOTHING);
	pharos_device_set_keyed(&device, now_us, true);
	assert_error(open_as(CREATE, "firmware.bin"), PROTECTED);
	pharos_device_set_keyed(&device, now_us, false);
	begin();
	pharos_device_set_keyed(&device, now_us, true);
	assert_error(write_at(0, 100), PROTECTED);
	zassert_equal(out.upload, MAVLINK_OUTBOX_UPLOAD_ABORT, "the right was lost on the way");
	zassert_equal(service.ftp.upload.state, MAVLINK_UPLOAD_IDLE);
}

ZTEST(mavlink_upload, test_its_session_is_no_reads_session)
{
	zassert_equal(ask((struct ask){.opcode = READ_ONLY, .size = 6, .data = "g.json"}), ACK);
	zassert_equal(answer.payload[2], 0);
	zassert_equal(open_as(CREATE, "firmware.bin"), LATER);
	zassert_equal(done(NULL), ACK);
	zassert_equal(answer.payload[2], 1);
	zassert_equal(
		ask((struct ask){.opcode = READ_ONLY, .session = 1, .size = 6, .data = "g.json"}),
		ACK);
	zassert_equal(answer.payload[2], 2);
}
