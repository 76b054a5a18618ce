/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What link threads have received, in buffers of the inbox's pools.
 */
#ifndef PHAROS_THREADS_FRAMES_H
#define PHAROS_THREADS_FRAMES_H

#include <stdint.h>

#include "proto/dronecan/transport.h"
#include "proto/mavlink/limits.h"

#ifdef CONFIG_PHAROS_IMC
#include "proto/imc/outbox.h"
#endif

/* MAVLink, from a UART. */
struct link_frame {
	uint8_t link; /* 0…LINKS_MAX - 1 */
	uint16_t length;
	uint8_t bytes[MAVLINK_FRAME_MAX];
};

#ifdef CONFIG_PHAROS_IMC
struct imc_frame {
	struct imc_route route;
	uint16_t length;
	uint8_t bytes[IMC_PACKET_MAX];
};
#endif

#endif
