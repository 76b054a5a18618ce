/* SPDX-License-Identifier: Apache-2.0 */
/* A node among others: announcements, heartbeats, peers, addresses, entities. */
#include <string.h>

#include <zephyr/ztest.h>

#include "peer.h"

#define SERVICES "imc+info://0.0.0.0/version/5.4.31;imc+udp://127.0.0.1:6442/"

static void before(void *fixture)
{
	device_start(SERVICES);
}

ZTEST_SUITE(imc_node, NULL, NULL, before, NULL, NULL);

static void heartbeat_from(uint16_t id, uint8_t link, uint16_t port)
{
	const struct imc_message message = {.id = IMC_HEARTBEAT};

	header.src = id;
	route = (struct imc_route){.link = link, .port = port, .address = port != 0 ? 1 : 0};
	send(&message);
}

static void ask(uint16_t id, uint8_t entity)
{
	const struct imc_message message = {.id = id};

	header.dst_ent = entity;
	send(&message);
}

static void announce(uint16_t id, const char *services)
{
	const struct imc_message message = {
		.id = IMC_ANNOUNCE,
		.announce = {.sys_name = text("v"), .services = text(services)},
	};

	header.src = id;
	header.dst = 0;
	route = (struct imc_route){.link = DATAGRAMS, .port = 30000, .address = 0x7F000001};
	send(&message);
}

/* IMC: every 10 s, dst 0, owner 0xFFFF. */
ZTEST(imc_node, test_announces_itself_every_ten_seconds)
{
	zassert_equal(pass(0, IMC_ANNOUNCE), 1, "at once");
	const struct imc_packet *const packet = sent(IMC_ANNOUNCE, 0);

	zassert_equal(sent_to(IMC_ANNOUNCE, 0)->to, IMC_TO_ANNOUNCE);
	zassert_equal(packet->header.src, DEVICE);
	zassert_equal(packet->header.dst, 0);
	zassert_equal(packet->message.announce.owner, 0xFFFF);
	zassert_equal(packet->message.announce.sys_type, 7); /* MOBILESENSOR */
	zassert_true(imc_text_is(&packet->message.announce.sys_name, "light-1"));
	zassert_true(imc_text_is(&packet->message.announce.services, SERVICES));
	zassert_equal(pass(9999999, IMC_ANNOUNCE), 0);
	zassert_equal(pass(10000000, IMC_ANNOUNCE), 1);
	zassert_equal(pass(100000000, IMC_ANNOUNCE), 9);
}

ZTEST(imc_node, test_without_datagrams_nothing_is_announced)
{
	device_start(NULL);
	zassert_equal(pass(100000000, IMC_ANNOUNCE), 0);
}

/* IMC: Heartbeat at 1 Hz to every peer that is known. */
ZTEST(imc_node, test_a_peer_gets_a_heartbeat_each_second)
{
	pass(500000, IMC_HEARTBEAT);
	heartbeat_from(VEHICLE, STREAM, 0);
	zassert_equal(pass(10500000, IMC_HEARTBEAT), 10);
	zassert_equal(sent(IMC_HEARTBEAT, 0)->header.dst, VEHICLE);
	zassert_equal(sent_to(IMC_HEARTBEAT, 0)->route.link, STREAM);
}

ZTEST(imc_node, test_a_stream_where_nobody_spoke_gets_heartbeats_for_everyone)
{
	zassert_equal(pass(0, IMC_HEARTBEAT), 1);
	zassert_equal(sent(IMC_HEARTBEAT, 0)->header.dst, IMC_DST_ALL);
	zassert_equal(sent_to(IMC_HEARTBEAT, 0)->route.link, STREAM);
}

/* IMC: peers stop 30 s after the last packet. */
ZTEST(imc_node, test_a_silent_peer_is_dropped)
{
	heartbeat_from(VEHICLE, DATAGRAMS, 6001);
	zassert_equal(endpoint.node.peers.count, 1);
	pass(29999999, IMC_HEARTBEAT);
	imc_endpoint_step(&endpoint, now_us, &out);
	zassert_equal(endpoint.node.peers.count, 1);
	pass(30000000, IMC_HEARTBEAT);
	zassert_equal(endpoint.node.peers.count, 0);
}

ZTEST(imc_node, test_a_full_table_keeps_whom_it_has)
{
	for (uint16_t i = 0; i < IMC_PEERS_MAX + 3; i++) {
		heartbeat_from((uint16_t)(0x4000 + i), DATAGRAMS, (uint16_t)(6000 + i));
	}
	zassert_equal(endpoint.node.peers.count, IMC_PEERS_MAX);
	zassert_equal(endpoint.node.peers.refused, 3);
	zassert_equal(endpoint.node.peers.peers[0].id, 0x4000);
	pass(20000000, IMC_HEARTBEAT);
	for (uint16_t i = 1; i < IMC_PEERS_MAX; i++) {
		heartbeat_from((uint16_t)(0x4000 + i), DATAGRAMS, (uint16_t)(6000 + i));
	}
	pass(31000000, IMC_HEARTBEAT);
	heartbeat_from(0x4999, DATAGRAMS, 7000);
	zassert_equal(endpoint.node.peers.count, IMC_PEERS_MAX, "in the place of the silent one");

	/* one that has no place is answered all the same */
	header.src = 0x5000;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(count(IMC_ENTITY_STATE), 1);
	zassert_equal(sent(IMC_ENTITY_STATE, 0)->header.dst, 0x5000);
}

/* IMC: the address is the announced one; 127.0.0.1 is 0x7F000001. */
ZTEST(imc_node, test_the_announced_address_counts)
{
	const struct imc_peer *const peer = &endpoint.node.peers.peers[0];

	heartbeat_from(VEHICLE, DATAGRAMS, 5555);
	zassert_equal(peer->route.port, 5555);
	announce(VEHICLE, "dune://x;imc+udp://10.0.0.9:7000/;imc+udp://127.0.0.1:6002/;imc+tcp://"
	                  "127.0.0.1:7001/");
	zassert_equal(peer->route.port, 6002, "the address that it came from");
	zassert_equal(peer->route.address, 0x7F000001);
	heartbeat_from(VEHICLE, DATAGRAMS, 5555);
	zassert_equal(peer->route.port, 6002, "packets from elsewhere don't change it");
	announce(VEHICLE, "imc+udp://10.0.0.9:7000/");
	zassert_equal(peer->route.port, 7000, "behind a translator: the first port");
	zassert_equal(peer->route.address, 0x7F000001);
	zassert_equal(endpoint.node.peers.count, 1);
}

/* imcpy's actors send from a socket that they close, and listen where they have announced. */
ZTEST(imc_node, test_who_has_announced_an_address_is_answered_there)
{
	announce(VEHICLE, "imc+udp://127.0.0.1:6001/");
	header.dst = DEVICE;
	route.port = 5555;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(count(IMC_ENTITY_STATE), 1);
	zassert_equal(out.packets[0].route.port, 6001);
	zassert_equal(out.packets[0].route.address, 0x7F000001);
	header.src = 0x5000;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(count(IMC_ENTITY_STATE), 1);
	zassert_equal(out.packets[0].route.port, 5555, "others at their source");
}

ZTEST(imc_node, test_announcements_without_a_usable_address)
{
	static const char *const services[] = {
		"",
		"imc+udp://",
		"imc+udp://127.0.0.1",
		"imc+udp://127.0.0.1:0/",
		"imc+udp://127.0.0.1:70000/",
		"imc+udp://127.0.0.256:6002/",
		"imc+udp://host:6002/",
		"imc+tcp://127.0.0.1:6002/",
		"imc+udp://1.2.3:6002/",
	};

	for (size_t i = 0; i < ARRAY_SIZE(services); i++) {
		device_start(SERVICES);
		announce(VEHICLE, services[i]);
		zassert_equal(endpoint.node.peers.count, 1);
		zassert_equal(endpoint.node.peers.peers[0].route.port, 30000, "where it came from");
	}
}

/* IMC: filter by dst and dst_ent. */
ZTEST(imc_node, test_packets_for_others_are_not_answered)
{
	header.dst = 0x8443;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_ALL);
	zassert_equal(out.packets_count, 0);
	header.dst = DEVICE;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_COUNT);
	zassert_equal(out.packets_count, 0);
	ask(IMC_QUERY_ENTITY_STATE, 254);
	zassert_equal(out.packets_count, 0);
	zassert_equal(endpoint.stats.not_for_us, 3);
	header.dst = IMC_DST_ALL;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_ALL);
	zassert_equal(count(IMC_ENTITY_STATE), IMC_ENTITY_COUNT);
}

ZTEST(imc_node, test_own_packets_that_come_back_are_ignored)
{
	header.src = DEVICE;
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_ALL);
	zassert_equal(out.packets_count, 0);
	zassert_equal(endpoint.stats.own, 1);
	zassert_equal(endpoint.node.peers.count, 0);
}

ZTEST(imc_node, test_answers_go_to_the_asker)
{
	route = (struct imc_route){.link = DATAGRAMS, .port = 6001, .address = 0x7F000001};
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(count(IMC_ENTITY_STATE), 1);
	const struct imc_packet *const answer = sent(IMC_ENTITY_STATE, 0);
	const struct imc_outbox_packet *const place = sent_to(IMC_ENTITY_STATE, 0);

	zassert_equal(answer->header.src, DEVICE);
	zassert_equal(answer->header.src_ent, IMC_ENTITY_LAMP);
	zassert_equal(answer->header.dst, VEHICLE);
	zassert_equal(answer->header.dst_ent, 7);
	zassert_equal(place->to, IMC_TO_ROUTE);
	zassert_equal(place->route.link, DATAGRAMS);
	zassert_equal(place->route.port, 6001);
}

ZTEST(imc_node, test_entity_list_and_info)
{
	const struct imc_message query = {.id = IMC_ENTITY_LIST,
	                                  .entity_list = {.op = 1 /* query */}};
	const struct imc_message report = {.id = IMC_ENTITY_LIST, .entity_list = {.op = 0}};
	struct imc_message info = {.id = IMC_QUERY_ENTITY_INFO, .query_entity_info = {.id = 1}};

	send(&query);
	zassert_equal(sent(IMC_ENTITY_LIST, 0)->message.entity_list.op, 0);
	zassert_mem_equal(sent(IMC_ENTITY_LIST, 0)->message.entity_list.list.bytes,
	                  "System=0;Lamp=1;Thermal=2;", 26);
	send(&report);
	zassert_equal(out.packets_count, 0, "a report is no query");

	header.dst_ent = IMC_ENTITY_THERMAL; /* IMC: matched by the header's dst_ent */
	send(&info);
	zassert_equal(sent(IMC_ENTITY_INFO, 0)->message.entity_info.id, 2);
	zassert_true(imc_text_is(&sent(IMC_ENTITY_INFO, 0)->message.entity_info.label, "Thermal"));
	header.dst_ent = IMC_ENTITY_ALL;
	send(&info);
	zassert_true(imc_text_is(&sent(IMC_ENTITY_INFO, 0)->message.entity_info.label, "Lamp"));
	info.query_entity_info.id = 200;
	send(&info);
	zassert_equal(out.packets_count, 0);
	zassert_equal(endpoint.node.stats.unknown_names, 1);
}

ZTEST(imc_node, test_version_and_activation)
{
	const struct imc_message request = {.id = IMC_VERSION_INFO};
	const struct imc_message reply = {.id = IMC_VERSION_INFO, .version_info = {.op = 1}};

	send(&request);
	zassert_equal(sent(IMC_VERSION_INFO, 0)->message.version_info.op, 1);
	zassert_true(
		imc_text_is(&sent(IMC_VERSION_INFO, 0)->message.version_info.version, "1.2.3"));
	send(&reply);
	zassert_equal(out.packets_count, 0);
	ask(IMC_QUERY_ENTITY_ACTIVATION_STATE, IMC_ENTITY_LAMP);
	zassert_equal(sent(IMC_ENTITY_ACTIVATION_STATE, 0)->message.entity_activation_state.state,
	              1);
}

/* IMC EntityState: 1 normal, 2 fault, 3 error, 4 failure. */
ZTEST(imc_node, test_a_changed_state_is_told_to_all_peers)
{
	static const struct device_effects reported = {.reports = 1};
	struct illuminator *const illuminator = &device.lamps[0].illuminator;

	illuminator->thermal.limit_ppm = PPM_ONE;
	heartbeat_from(VEHICLE, STREAM, 0);
	imc_endpoint_tell(&endpoint, now_us, &reported, &out);
	zassert_true(imc_endpoint_deadline_us(&endpoint) <= now_us);
	zassert_equal(pass(0, IMC_ENTITY_STATE), IMC_ENTITY_COUNT, "booted: all are normal");
	zassert_equal(sent_to(IMC_ENTITY_STATE, 0)->to, IMC_TO_PEERS);
	zassert_equal(sent(IMC_ENTITY_STATE, IMC_ENTITY_LAMP)->message.entity_state.state, 1);
	imc_endpoint_tell(&endpoint, now_us, &reported, &out);
	zassert_equal(pass(999999, IMC_ENTITY_STATE), 0, "no news");

	illuminator->thermal.flags = THERMAL_FLAG_SHUTDOWN;
	illuminator->thermal.limit_ppm = 0;
	imc_endpoint_tell(&endpoint, now_us, &reported, &out);
	zassert_equal(pass(now_us, IMC_ENTITY_STATE), 1);
	zassert_equal(sent(IMC_ENTITY_STATE, 0)->header.src_ent, IMC_ENTITY_LAMP);
	zassert_equal(sent(IMC_ENTITY_STATE, 0)->message.entity_state.state, 3);

	illuminator->thermal.fault = THERMAL_FAULT_OPEN;
	imc_endpoint_tell(&endpoint, now_us, &reported, &out);
	pass(now_us, IMC_ENTITY_STATE);
	zassert_equal(endpoint.node.entities.conditions[IMC_ENTITY_THERMAL].state, 4);
}

/* 2023-11-14T22:13:20.25Z, and what comes from devices without a calendar. */
ZTEST(imc_node, test_packets_carry_the_peers_time)
{
	pass(2500000, IMC_HEARTBEAT);
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(sent(IMC_ENTITY_STATE, 0)->header.timestamp_s, 2.5, "since boot");
	header.timestamp_s = 1700000000.25;
	heartbeat_from(VEHICLE, STREAM, 0);
	pass(3500000, IMC_HEARTBEAT);
	header.timestamp_s = 12.0;
	heartbeat_from(VEHICLE, STREAM, 0);
	ask(IMC_QUERY_ENTITY_STATE, IMC_ENTITY_LAMP);
	zassert_equal(sent(IMC_ENTITY_STATE, 0)->header.timestamp_s, 1700000001.25);
}

ZTEST(imc_node, test_a_heartbeat_is_a_sign_of_life)
{
	heartbeat_from(VEHICLE, STREAM, 0);
	zassert_equal(device.lamps[0].arbiter.heard_us, now_us);
}

/* Two lights that hear each other, and nobody else, have lost their link. */
ZTEST(imc_node, test_other_sensors_and_announcements_are_no_sign_of_life)
{
	heartbeat_from(0x8443, STREAM, 0);
	zassert_equal(device.lamps[0].arbiter.heard_us, -1);
	zassert_equal(endpoint.node.peers.count, 1);
	announce(VEHICLE, "");
	zassert_equal(device.lamps[0].arbiter.heard_us, -1);
}

ZTEST(imc_node, test_unknown_and_malformed_packets_are_counted)
{
	uint8_t bytes[IMC_HEADER_SIZE + 4] = {0x54, 0xFE, 0xE7, 0xFD};

	imc_endpoint_receive(&endpoint, 0, &route, bytes, &out);
	zassert_equal(endpoint.stats.unknown_ids, 1);
	bytes[2] = 0x3A; /* SetLedBrightness, 314, with no payload */
	bytes[3] = 0x01;
	imc_endpoint_receive(&endpoint, 0, &route, bytes, &out);
	zassert_equal(endpoint.stats.malformed, 1);
	zassert_equal(out.packets_count, 0);
	zassert_equal(endpoint.stats.packets, 2);
}
