/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzzes IMC's stream, codec, node and actuation with a core behind them, over a small script:
 *
 *   op 0…1   bytes follow (count first): they arrive on that stream as they are
 *   op 2…5   a packet follows: choice of message, header, payload; it arrives with a good checksum,
 *            little or big endian, on a stream or as a datagram
 *   op 6     time moves, the endpoint steps until it is content
 *   op 7     the thermal supervisor reports
 *   op 8     the line falls silent
 *   op 9     a button
 *
 * Holds after each: what is sent are whole, good packets of ours; what decodes encodes to bytes
 * that decode to the same; settings and parameters are in range.
 */
#include "core/device.h"
#include "proto/imc/endpoint.h"
#include "proto/imc/stream.h"

#include "check.h"

#include <string.h>

#define STREAMS   2
#define DATAGRAMS 4
#define OWN_ID    0x8442

struct script {
	const uint8_t *at;
	const uint8_t *end;
};

static struct pharos_device device;
static struct imc_endpoint endpoint;
static struct imc_outbox out;
static struct imc_stream streams[STREAMS];
static bool params_changed;
static int64_t now_us;

static void start(void)
{
	static const struct device_config board = {
		.gimbal = true,
		.actuators.power = 0x1F,
		.actuators.power_on = 0x03,
		.actuators.pwms = 0x07,
		.actuators.leds = 0x03,
		.actuators.gpio_outputs = 0x03,
		.actuators.gpio_inputs = 0x0C,
		.actuators.thruster = true,
		.actuators.focus = true,
		.actuators.display = true,
	};
	static const struct imc_endpoint_config config = {
		.id = OWN_ID,
		.node =
			{
				.name = "light",
				.version = "1",
				.services = "imc+udp://127.0.0.1:6442/",
				.stream_links = 3,
			},
	};

	now_us = 0;
	params_changed = false;
	params_init(&device.params);
	device.params.values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&device, 0, &board);
	imc_endpoint_init(&endpoint, 0, &config, &device);
	for (size_t i = 0; i < STREAMS; i++) {
		imc_stream_init(&streams[i]);
	}
}

static uint8_t take(struct script *script)
{
	return script->at < script->end ? *script->at++ : 0;
}

static void check_state(void)
{
	const struct illuminator_settings *const s = &device.lamps[0].illuminator.settings;
	struct params *const params = &device.params;
	struct param_set changed;

	CHECK(s->brightness_ppm <= PPM_ONE && s->duty_ppm <= PPM_ONE);
	CHECK(s->strobe_period_us == 0 ||
	      (s->strobe_period_us >= 1000 && s->strobe_period_us <= 60000000));
	for (uint32_t i = 0; params_changed && i < PARAM_COUNT; i++) {
		const enum params_result same = params_set(params, i, params->values[i], &changed);

		CHECK(same == PARAMS_OK || same == PARAMS_READ_ONLY);
	}
}

static void check_sent(void)
{
	struct imc_packet packet;

	struct device_effects effects;

	if (pharos_device_take(&device, &effects)) {
		params_changed |= !param_set_is_empty(&effects.params);
		imc_endpoint_tell(&endpoint, now_us, &effects, &out);
	}
	for (uint8_t i = 0; i < out.packets_count; i++) {
		const struct imc_outbox_packet *const sent = &out.packets[i];

		CHECK(sent->offset + sent->length <= out.used && out.used <= IMC_OUTBOX_BYTES);
		CHECK(imc_decode(&out.bytes[sent->offset], sent->length, &packet) == IMC_OK);
		CHECK(packet.header.src == OWN_ID);
	}
	CHECK(endpoint.node.peers.count <= IMC_PEERS_MAX);
}

/* The same values again, whatever the byte order was. */
static void check_codec(const uint8_t *bytes, size_t length)
{
	static uint8_t once[IMC_PACKET_MAX];
	static uint8_t twice[IMC_PACKET_MAX];
	struct imc_packet packet;

	if (imc_decode(bytes, length, &packet) != IMC_OK) {
		return;
	}
	const size_t size = imc_encode(&packet, once, sizeof(once));

	CHECK(size > 0 && size <= length);
	CHECK(imc_decode(once, size, &packet) == IMC_OK);
	CHECK(imc_encode(&packet, twice, sizeof(twice)) == size);
	CHECK(memcmp(once, twice, size) == 0);
}

static void arrive(const struct imc_route *route, const uint8_t *bytes, size_t length)
{
	check_codec(bytes, length);
	imc_endpoint_receive(&endpoint, now_us, route, bytes, &out);
	check_sent();
}

static void take_packets(uint8_t link)
{
	const struct imc_route route = {.link = link};
	struct imc_stream_packet packet;

	while (imc_stream_next(&streams[link], &packet)) {
		CHECK(packet.length <= IMC_PACKET_MAX);
		arrive(&route, packet.bytes, packet.length);
	}
}

static void write_all(uint8_t link, const uint8_t *bytes, size_t count)
{
	while (count > 0) {
		const size_t taken = imc_stream_write(&streams[link], bytes, count);

		CHECK(taken > 0 && taken <= count);
		bytes += taken;
		count -= taken;
		take_packets(link);
	}
}

/* A stream that gets bytes only when it has as many as it wanted finds the same packets as soon. */
static void compare_wanted(const uint8_t *bytes, size_t size)
{
	static struct imc_stream eager;
	static struct imc_stream patient;
	struct imc_stream_packet packet;
	size_t given = 0;

	imc_stream_init(&eager);
	imc_stream_init(&patient);
	for (size_t come = 1; come <= size; come++) {
		const size_t wanted = imc_stream_wanted(&patient);

		CHECK(wanted >= 1 && wanted <= IMC_PACKET_MAX);
		CHECK(imc_stream_write(&eager, bytes + come - 1, 1) == 1);
		while (imc_stream_next(&eager, &packet)) {
		}
		if (come - given < wanted) {
			CHECK(eager.stats.packets == patient.stats.packets);
			continue;
		}
		while (given < come) {
			given += imc_stream_write(&patient, bytes + given, come - given);
			while (imc_stream_next(&patient, &packet)) {
			}
		}
		CHECK(eager.stats.packets == patient.stats.packets);
	}
}

static void raw(struct script *script, uint8_t link)
{
	const size_t left = (size_t)(script->end - script->at);
	const size_t wanted = take(script);
	const size_t count = wanted < left ? wanted : (left > 0 ? left - 1 : 0);

	compare_wanted(script->at, count);
	write_all(link, script->at, count);
	script->at += count;
}

static void put_u16(uint8_t *at, uint16_t value, bool big_endian)
{
	at[big_endian ? 0 : 1] = (uint8_t)(value >> 8);
	at[big_endian ? 1 : 0] = (uint8_t)value;
}

/* A packet with a good checksum; the payload is the script's. */
static void packet(struct script *script, uint8_t op)
{
	static uint8_t bytes[IMC_HEADER_SIZE + UINT8_MAX + IMC_FOOTER_SIZE];
	const struct imc_type *const type = &imc_types[take(script) % imc_types_count];
	const uint8_t choice = take(script);
	const uint8_t size = take(script);
	const bool big_endian = (op & 1) != 0;
	const struct imc_route datagram = {
		.link = DATAGRAMS,
		.port = (uint16_t)(6000 + (choice & 15)),
		.address = 0x7F000001,
	};

	bytes[0] = big_endian ? 0xFE : 0x54;
	bytes[1] = big_endian ? 0x54 : 0xFE;
	put_u16(&bytes[2], (choice & 0x80) != 0 ? 64999 : type->id, big_endian);
	put_u16(&bytes[4], size, big_endian);
	for (size_t i = 6; i < 14; i++) {
		bytes[i] = take(script);
	}
	put_u16(&bytes[14], (uint16_t)(0x4000 + choice), big_endian);
	bytes[16] = choice;
	put_u16(&bytes[17], (choice & 0x40) != 0 ? 0x1234 : OWN_ID, big_endian);
	bytes[19] = (choice & 0x20) != 0 ? take(script) : 255;
	for (size_t i = 0; i < size; i++) {
		bytes[IMC_HEADER_SIZE + i] = take(script);
	}
	put_u16(&bytes[IMC_HEADER_SIZE + size], imc_checksum(bytes, IMC_HEADER_SIZE + size),
	        big_endian);
	if ((op & 2) != 0) {
		arrive(&datagram, bytes, IMC_HEADER_SIZE + size + IMC_FOOTER_SIZE);
	} else {
		write_all(choice & 1, bytes, IMC_HEADER_SIZE + size + IMC_FOOTER_SIZE);
	}
}

static void time_moves(struct script *script)
{
	int steps = 0;

	now_us += (int64_t)take(script) * 100000 + take(script);
	while (imc_endpoint_deadline_us(&endpoint) <= now_us ||
	       pharos_device_deadline_us(&device) <= now_us) {
		pharos_device_step(&device, now_us);
		imc_endpoint_step(&endpoint, now_us, &out);
		check_sent();
		CHECK(++steps < 100);
	}
}

static void heat(struct script *script)
{
	const uint8_t choice = take(script);
	const struct thermal_report report = {
		.state = (enum thermal_state)(choice % 3),
		.sensor = choice & 0x40 ? THERMAL_SENSOR_FAILED : THERMAL_SENSOR_OK,
		.fault = choice & 0x40 ? THERMAL_FAULT_STUCK : THERMAL_FAULT_NONE,
		.flags = choice % 3,
		.temp_mdegc = choice * 1000,
		.temp_valid = (choice & 0x40) == 0,
	};

	pharos_device_report_heat(&device, now_us, 0, &report);
	check_sent();
}

static void silence(void)
{
	for (uint8_t link = 0; link < STREAMS; link++) {
		const struct imc_route route = {.link = link};
		struct imc_stream_packet found;

		while (imc_stream_idle(&streams[link], &found)) {
			arrive(&route, found.bytes, found.length);
			take_packets(link);
		}
	}
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct script script = {data, data + size};

	start();
	while (script.at < script.end) {
		const uint8_t op = take(&script) % 10;

		if (op < 2) {
			raw(&script, op);
		} else if (op < 6) {
			packet(&script, (uint8_t)(op - 2));
		} else if (op == 6) {
			time_moves(&script);
		} else if (op == 7) {
			heat(&script);
		} else if (op == 8) {
			silence();
		} else {
			imc_endpoint_button(&endpoint, now_us, take(&script), true, &out);
			check_sent();
		}
	}
	check_state();
	return 0;
}
