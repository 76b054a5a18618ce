/* SPDX-License-Identifier: Apache-2.0 */
#include "peer.h"

#include <string.h>

#include <zephyr/ztest.h>

struct pharos_device device;
struct params *const params = &device.params;
struct device_effects effects;
struct device_config device_board = {.gimbal = true};
struct imc_endpoint endpoint;
struct imc_outbox out;
struct imc_header header;
struct imc_route route;
int64_t now_us;

void device_start(const char *services)
{
	const struct imc_endpoint_config config = {
		.id = DEVICE,
		.node =
			{
				.name = "light-1",
				.version = "1.2.3",
				.services = services,
				.stream_links = 1u << STREAM,
			},
	};

	now_us = 0;
	params_init(params);
	params->values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&device, now_us, &device_board);
	params_init(params);
	imc_endpoint_init(&endpoint, now_us, &config, &device);
	header = (struct imc_header){
		.timestamp_s = 0,
		.src = VEHICLE,
		.src_ent = 7,
		.dst = DEVICE,
		.dst_ent = IMC_ENTITY_ALL,
	};
	route = (struct imc_route){.link = STREAM};
	out.packets_count = 0;
}

/* As the command thread does it. */
static void settle(void)
{
	memset(&effects, 0, sizeof(effects));
	if (pharos_device_take(&device, &effects)) {
		imc_endpoint_tell(&endpoint, now_us, &effects, &out);
	}
}

void send(const struct imc_message *message)
{
	const struct imc_packet packet = {.header = header, .message = *message};
	uint8_t bytes[IMC_PACKET_MAX];

	zassert_true(imc_encode(&packet, bytes, sizeof(bytes)) > 0, "the test's own packet");
	imc_endpoint_receive(&endpoint, now_us, &route, bytes, &out);
	settle();
}

uint32_t pass(int64_t until_us, uint16_t id)
{
	uint32_t total = 0;

	for (;;) {
		const int64_t device_us = pharos_device_deadline_us(&device);
		const int64_t endpoint_us = imc_endpoint_deadline_us(&endpoint);
		const int64_t due_us = device_us < endpoint_us ? device_us : endpoint_us;

		if (due_us > until_us) {
			break;
		}
		now_us = due_us > now_us ? due_us : now_us;
		pharos_device_step(&device, now_us);
		out.packets_count = 0;
		if (imc_endpoint_deadline_us(&endpoint) <= now_us) {
			imc_endpoint_step(&endpoint, now_us, &out);
			zassert_true(imc_endpoint_deadline_us(&endpoint) > now_us,
			             "it comes to rest");
		}
		settle();
		total += count(id);
	}
	now_us = until_us;
	return total;
}

/* The place of the i-th packet of that id; NULL: there is none. */
static const struct imc_outbox_packet *find(uint16_t id, uint32_t index)
{
	for (uint8_t i = 0; i < out.packets_count; i++) {
		const uint8_t *const bytes = &out.bytes[out.packets[i].offset];

		if ((bytes[2] | bytes[3] << 8) == id && index-- == 0) {
			return &out.packets[i];
		}
	}
	return NULL;
}

uint32_t count(uint16_t id)
{
	uint32_t found = 0;

	while (find(id, found) != NULL) {
		found++;
	}
	return found;
}

const struct imc_outbox_packet *sent_to(uint16_t id, uint32_t index)
{
	const struct imc_outbox_packet *const place = find(id, index);

	zassert_not_null(place, "packet %u of message %u", index, id);
	return place;
}

const struct imc_packet *sent(uint16_t id, uint32_t index)
{
	static struct imc_packet packet;
	const struct imc_outbox_packet *const place = sent_to(id, index);

	zassert_equal(imc_decode(&out.bytes[place->offset], place->length, &packet), IMC_OK);
	return &packet;
}

struct imc_text text(const char *string)
{
	return imc_text_of(string);
}
