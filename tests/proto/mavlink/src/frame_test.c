/* SPDX-License-Identifier: Apache-2.0 */
/* Frames: the checksum, reading and building, against frames that pymavlink packed. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_frame, NULL, NULL, NULL, NULL, NULL);

ZTEST(mavlink_frame, test_checksum_is_crc16_mcrf4xx)
{
	/* CRC catalogue, reveng.sourceforge.io: CRC-16/MCRF4XX of "123456789" is 0x6F91. */
	zassert_equal(mavlink_checksum((const uint8_t *)"123456789", 9, 0xFFFF), 0x6F91);
}

ZTEST(mavlink_frame, test_crc_extra_of_known_and_unknown_ids)
{
	uint8_t extra = 0;

	zassert_true(mavlink_crc_extra(0, &extra)); /* HEARTBEAT 50, mavlink.io */
	zassert_equal(extra, 50);
	zassert_true(mavlink_crc_extra(440, &extra)); /* reference: 440 has 66 */
	zassert_equal(extra, 66);
	zassert_true(mavlink_crc_extra(396, &extra)); /* reference: 396 has 50 */
	zassert_equal(extra, 50);
	zassert_true(mavlink_crc_extra(178, &extra)); /* ardupilotmega.xml AHRS2: 47 */
	zassert_equal(extra, 47);
	zassert_false(mavlink_crc_extra(0xFFFFFF, &extra));
	zassert_false(mavlink_crc_extra(65536 + 440, &extra));
}

ZTEST(mavlink_frame, test_view_reads_version_2)
{
	struct mavlink_frame frame;

	zassert_true(mavlink_frame_view(COMMAND_ON_V2, sizeof(COMMAND_ON_V2), &frame));
	zassert_equal(frame.version, 2);
	zassert_equal(frame.message_id, 76);
	zassert_equal(frame.sequence, 7);
	zassert_equal(frame.system_id, 255);
	zassert_equal(frame.component_id, 190);
	zassert_equal(frame.payload_length, 32);
	zassert_equal_ptr(frame.payload, COMMAND_ON_V2 + 10);
	zassert_false(frame.has_signature);
}

ZTEST(mavlink_frame, test_view_reads_version_1)
{
	struct mavlink_frame frame;

	zassert_true(mavlink_frame_view(COMMAND_ON_V1, sizeof(COMMAND_ON_V1), &frame));
	zassert_equal(frame.version, 1);
	zassert_equal(frame.message_id, 76);
	zassert_equal(frame.sequence, 7);
	zassert_equal(frame.payload_length, 33);
	zassert_equal_ptr(frame.payload, COMMAND_ON_V1 + 6);
}

ZTEST(mavlink_frame, test_view_reads_signed)
{
	struct mavlink_frame frame;

	zassert_true(mavlink_frame_view(HEARTBEAT_SIGNED, sizeof(HEARTBEAT_SIGNED), &frame));
	zassert_true(frame.has_signature);
	zassert_equal(frame.payload_length, 9);
	zassert_equal(frame.length, 10 + 9 + 2 + 13);
}

ZTEST(mavlink_frame, test_view_refuses_what_is_not_one_frame)
{
	uint8_t bytes[sizeof(COMMAND_ON_V2) + 1] = {0};
	struct mavlink_frame frame;

	memcpy(bytes, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	for (size_t length = 0; length <= sizeof(bytes); length++) {
		zassert_equal(mavlink_frame_view(bytes, length, &frame),
		              length == sizeof(COMMAND_ON_V2), "%u bytes", (unsigned int)length);
	}
	bytes[2] = 0x02; /* an incompatibility flag that nobody has defined */
	zassert_false(mavlink_frame_view(bytes, sizeof(COMMAND_ON_V2), &frame));
	bytes[2] = 0;
	bytes[0] = 0x55;
	zassert_false(mavlink_frame_view(bytes, sizeof(COMMAND_ON_V2), &frame));
}

ZTEST(mavlink_frame, test_truncated_payload_reads_as_zeros)
{
	struct mavlink_frame frame;
	mavlink_command_long_t wire;

	memset(&wire, 0xA5, sizeof(wire));
	zassert_true(mavlink_frame_view(COMMAND_ON_V2, sizeof(COMMAND_ON_V2), &frame));
	mavlink_frame_payload(&frame, &wire, sizeof(wire));
	zassert_equal(wire.command, 405);
	zassert_equal(wire.confirmation, 0); /* byte 32, not sent */
	zassert_equal(mavlink_frame_byte(&frame, 30), 1);
	zassert_equal(mavlink_frame_byte(&frame, 32), 0);
}

ZTEST(mavlink_frame, test_build_equals_pymavlink)
{
	static const struct mavlink_kind heartbeat = MAVLINK_KIND(HEARTBEAT);
	static const struct mavlink_kind ack_kind = MAVLINK_KIND(COMMAND_ACK);
	const mavlink_heartbeat_t alive = {
		.type = 44, .autopilot = 8, .system_status = 4, .mavlink_version = 3};
	const mavlink_command_ack_t ack = {
		.command = 405, .target_system = 255, .target_component = 190};
	struct mavlink_sender light_id = {.version = 2, .system_id = 1, .component_id = 243};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	zassert_equal(mavlink_frame_build(bytes, &light_id, &heartbeat, &alive), sizeof(HEARTBEAT));
	zassert_mem_equal(bytes, HEARTBEAT, sizeof(HEARTBEAT));
	zassert_equal(mavlink_frame_build(bytes, &light_id, &ack_kind, &ack), sizeof(ACK_ON_V2));
	zassert_mem_equal(bytes, ACK_ON_V2, sizeof(ACK_ON_V2));
	light_id.version = 1;
	zassert_equal(mavlink_frame_build(bytes, &light_id, &ack_kind, &ack), sizeof(ACK_ON_V1));
	zassert_mem_equal(bytes, ACK_ON_V1, sizeof(ACK_ON_V1));
}

ZTEST(mavlink_frame, test_version_1_cannot_carry_ids_above_255)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(ILLUMINATOR_STATUS);
	const struct mavlink_sender sender = {.version = 1, .system_id = 1, .component_id = 243};
	const mavlink_illuminator_status_t status = {0};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	zassert_equal(mavlink_frame_build(bytes, &sender, &kind, &status), 0);
}

ZTEST(mavlink_frame, test_a_payload_of_zeros_keeps_one_byte)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const struct mavlink_sender sender = {.version = 2, .system_id = 1, .component_id = 243};
	const mavlink_heartbeat_t nothing = {0};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	/* mavlink.io serialization: "The first byte of the payload is never truncated". */
	zassert_equal(mavlink_frame_build(bytes, &sender, &kind, &nothing), 10 + 1 + 2);
}
