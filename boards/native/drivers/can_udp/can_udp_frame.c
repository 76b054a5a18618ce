/* SPDX-License-Identifier: Apache-2.0 */
#include "can_udp_frame.h"

#include <string.h>

#define MAGIC       0x2934u
#define FLAG_FD     0x0001u
#define ID_EXTENDED (1u << 31)
#define ID_REMOTE   (1u << 30)
#define ID_ERROR    (1u << 29)
#define CRC_SEED    0xFFFFu

enum {
	AT_CRC = 2,
	AT_FLAGS = 4,
	AT_ID = 6,
};

static uint16_t crc16(const uint8_t *data, size_t length)
{
	uint16_t crc = CRC_SEED;

	for (size_t i = 0; i < length; i++) {
		crc = (uint16_t)((crc >> 8) | (crc << 8));
		crc ^= data[i];
		crc ^= (uint16_t)((crc & 0xFFu) >> 4);
		crc ^= (uint16_t)(crc << 12);
		crc ^= (uint16_t)((crc & 0xFFu) << 5);
	}
	return crc;
}

static void put16(uint8_t *at, uint32_t value)
{
	at[0] = (uint8_t)value;
	at[1] = (uint8_t)(value >> 8);
}

static uint32_t get16(const uint8_t *at)
{
	return at[0] | (uint32_t)at[1] << 8;
}

size_t can_udp_encode(const struct can_host_frame *frame, uint8_t datagram[CAN_UDP_MAX])
{
	const size_t length =
		frame->length < CAN_HOST_DATA_MAX ? frame->length : (size_t)CAN_HOST_DATA_MAX;
	uint32_t id = frame->id;

	id |= (frame->flags & CAN_HOST_EXTENDED) != 0 ? ID_EXTENDED : 0;
	id |= (frame->flags & CAN_HOST_REMOTE) != 0 ? ID_REMOTE : 0;
	put16(datagram, MAGIC);
	put16(datagram + AT_FLAGS, (frame->flags & CAN_HOST_FD) != 0 ? FLAG_FD : 0);
	put16(datagram + AT_ID, id);
	put16(datagram + AT_ID + 2, id >> 16);
	memcpy(datagram + CAN_UDP_HEADER, frame->data, length);
	put16(datagram + AT_CRC, crc16(datagram + AT_FLAGS, CAN_UDP_HEADER - AT_FLAGS + length));
	return CAN_UDP_HEADER + length;
}

static bool has_length_code(size_t length)
{
	static const uint8_t longer[] = {12, 16, 20, 24, 32, 48, 64};

	return length <= CAN_HOST_CLASSIC_MAX ||
	       memchr(longer, (int)length, sizeof(longer)) != NULL;
}

bool can_udp_decode(const uint8_t *datagram, size_t length, struct can_host_frame *frame)
{
	struct can_host_frame read = {0};
	uint32_t id;
	bool fd;

	if (length < CAN_UDP_HEADER || length > CAN_UDP_MAX || get16(datagram) != MAGIC ||
	    get16(datagram + AT_CRC) != crc16(datagram + AT_FLAGS, length - AT_FLAGS)) {
		return false;
	}
	fd = (get16(datagram + AT_FLAGS) & FLAG_FD) != 0;
	id = get16(datagram + AT_ID) | get16(datagram + AT_ID + 2) << 16;
	read.length = (uint8_t)(length - CAN_UDP_HEADER);
	read.id = id & CAN_HOST_EXT_ID_MAX;
	read.flags = (uint8_t)((fd ? CAN_HOST_FD | CAN_HOST_BRS : 0) |
	                       ((id & ID_EXTENDED) != 0 ? CAN_HOST_EXTENDED : 0) |
	                       ((id & ID_REMOTE) != 0 ? CAN_HOST_REMOTE : 0));
	if ((id & ID_ERROR) != 0 || !has_length_code(read.length) ||
	    (!fd && read.length > CAN_HOST_CLASSIC_MAX) || (fd && (id & ID_REMOTE) != 0) ||
	    ((id & ID_EXTENDED) == 0 && read.id > CAN_HOST_STD_ID_MAX)) {
		return false;
	}
	memcpy(read.data, datagram + CAN_UDP_HEADER, read.length);
	*frame = read;
	return true;
}
