/* SPDX-License-Identifier: Apache-2.0 */
/* What the transport must know of a data type; the generated dsdl.h has one of each. */
#ifndef PHAROS_PROTO_DRONECAN_TYPE_H
#define PHAROS_PROTO_DRONECAN_TYPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct dronecan_type {
	uint64_t signature;
	uint16_t id;
	/* CRC-16-CCITT-FALSE of the signature's eight bytes: where a transfer's CRC starts. */
	uint16_t crc_seed;
	/* Bytes of the longest message or request, and of the longest response. */
	uint16_t max_size;
	uint16_t max_response_size;
	bool service;
};

#endif
