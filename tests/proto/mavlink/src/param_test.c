/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters: reads, lists and their pace, sets of every kind, what others change. */
#include "fixture.h"

#include "proto/mavlink/gimbal_service.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_param, NULL, NULL, fixture_before, NULL, NULL);

/* PARAM_VALUE on the wire: 10 header, 25 payload (its last byte is a type, never 0), 2 checksum. */
#define VALUE_BYTES   37
/* 46 % of 57600 baud (10 bits a byte): 37 bytes take 13 964 us. */
#define VALUE_TIME_US 13964

/* The gimbal's component has all of GMB_ but GMB_ENABLE and GMB_COMPID. */
#define GIMBALS_COUNT 20
#define COUNT         (PARAM_COUNT - GIMBALS_COUNT)

static void set_typed(uint8_t link, const char *name, const void *bytes, uint8_t type,
                      uint8_t component)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PARAM_SET);
	mavlink_param_set_t wire = {
		.target_system = 1, .target_component = component, .param_type = type};

	memcpy(&wire.param_value, bytes, sizeof(wire.param_value));
	memcpy(wire.param_id, name, strlen(name) < 16 ? strlen(name) : 16);
	receive_message(link, &kind, &wire);
}

static void set(uint8_t link, const char *name, int32_t value)
{
	set_typed(link, name, &value, 6 /* MAV_PARAM_TYPE_INT32 */, 243);
}

static void ask(uint8_t link, const char *name, int16_t index, uint8_t component)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PARAM_REQUEST_READ);
	mavlink_param_request_read_t wire = {
		.target_system = 1, .target_component = component, .param_index = index};

	memcpy(wire.param_id, name, strlen(name));
	receive_message(link, &kind, &wire);
}

static void ask_list(uint8_t link)
{
	receive(link, PARAM_LIST, sizeof(PARAM_LIST));
}

static bool is_gimbals(uint32_t index)
{
	const char *const name = params_info(index)->name;

	return strncmp(name, "GMB_", 4) == 0 && strcmp(name, "GMB_ENABLE") != 0 &&
	       strcmp(name, "GMB_COMPID") != 0;
}

/* Among those of the same component. */
static uint16_t place_of(uint32_t index)
{
	uint16_t place = 0;

	for (uint32_t i = 0; i < index; i++) {
		if (is_gimbals(i) == is_gimbals(index)) {
			place++;
		}
	}
	return place;
}

/* Frame i is a PARAM_VALUE, of the component that has the parameter. Which it is. */
static uint32_t sent_value(uint16_t i, mavlink_param_value_t *wire)
{
	const struct mavlink_frame frame = sent(i);
	char name[17] = {0};
	uint32_t index;

	zassert_equal(frame.message_id, 22);
	mavlink_frame_payload(&frame, wire, sizeof(*wire));
	memcpy(name, wire->param_id, 16);
	index = params_find(name, strlen(name));
	zassert_true(index < PARAM_COUNT, "%s", name);
	zassert_equal(frame.component_id, is_gimbals(index) ? 154 : 243);
	return index;
}

/* Frame i is a PARAM_VALUE of that parameter on that link, complete, a REAL32 in its unit. */
static void assert_value(uint16_t i, uint8_t link, uint32_t index, float value)
{
	mavlink_param_value_t wire;
	const char *const name = params_info(index)->name;

	zassert_equal(sent_value(i, &wire), index, "%.16s", wire.param_id);
	zassert_equal(out.frames[i].link, link);
	zassert_equal(wire.param_index, place_of(index), "index %u", wire.param_index);
	zassert_equal(wire.param_value, value, "%s is %g, not %g", name, (double)wire.param_value,
	              (double)value);
	zassert_equal(wire.param_type, 9); /* MAV_PARAM_TYPE_REAL32 */
	zassert_equal(wire.param_count, is_gimbals(index) ? GIMBALS_COUNT : COUNT);
}

static void assert_error(uint16_t i, const char *name, int16_t index, uint8_t error)
{
	mavlink_param_error_t wire;
	char text[17] = {0};

	sent_payload(i, 345, &wire, sizeof(wire));
	memcpy(text, wire.param_id, 16);
	zassert_equal(wire.error, error, "error %u, not %u", wire.error, error);
	zassert_equal(wire.param_index, index);
	zassert_equal(strcmp(text, name), 0, "'%s'", text);
	zassert_equal(wire.target_system, 255);
	zassert_equal(wire.target_component, 190);
}

static void add_gimbal(void)
{
	static struct mavlink_gimbal gimbal;

	mavlink_gimbal_init(&gimbal, &device, service.identity);
	mavlink_endpoint_add(&endpoint, now_us, 154, &mavlink_gimbal_profile, &gimbal);
}

static float natural(uint32_t index)
{
	static const double scales[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};

	return (float)(device_params->values[index] / scales[params_info(index)->decimals]);
}

ZTEST(mavlink_param, test_every_parameter_reads_by_index_and_by_name)
{
	add_gimbal();
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const uint8_t component = is_gimbals(i) ? 154 : 243;

		ask(0, "", (int16_t)place_of(i), component);
		zassert_equal(out.count, 1);
		assert_value(0, 0, i, natural(i));
		ask(1, params_info(i)->name, -1, component);
		zassert_equal(out.count, 1);
		assert_value(0, 1, i, natural(i));
	}
}

ZTEST(mavlink_param, test_an_index_counts_before_a_name)
{
	ask(0, "STRB_MAX", PARAM_STRB_MIN, 243);
	assert_value(0, 0, PARAM_STRB_MIN, 0.01f);
}

ZTEST(mavlink_param, test_what_does_not_exist_is_refused_by_the_one_that_was_asked)
{
	receive(0, PARAM_READ_UNKNOWN, sizeof(PARAM_READ_UNKNOWN));
	zassert_equal(out.count, 1);
	assert_sent(0, 0, PARAM_ERROR_UNKNOWN, sizeof(PARAM_ERROR_UNKNOWN));
	ask(0, "", COUNT, 243);
	assert_error(0, "", COUNT, 1);
	ask(0, "", -2, 243);
	assert_error(0, "", -2, 1);
	set(0, "NONE", 1);
	zassert_equal(out.count, 1);
	assert_error(0, "NONE", -1, 1);
}

ZTEST(mavlink_param, test_what_every_component_is_asked_for_may_be_anothers)
{
	const int32_t value = 1;

	ask(0, "SERVO1_MIN", -1, 0);
	zassert_equal(out.count, 0);
	set_typed(0, "SERVO1_MIN", &value, 6, 0);
	zassert_equal(out.count, 0);
	zassert_equal(service.params.stats.unknown, 2);
	ask(0, "LGT_CURVE", -1, 0);
	assert_value(0, 0, PARAM_LGT_CURVE, 1);
	set_typed(0, "LGT_RESTORE", &value, 6, 0);
	assert_value(0, 0, PARAM_LGT_RESTORE, 1);
}

ZTEST(mavlink_param, test_other_components_and_systems_are_not_answered_for)
{
	const int32_t value = 0;

	ask(0, "LGT_CURVE", -1, 154);
	zassert_equal(out.count, 0);
	set_typed(0, "LGT_CURVE", &value, 6, 1);
	zassert_equal(out.count, 0);
	zassert_equal(device_params->values[PARAM_LGT_CURVE], 1);
}

ZTEST(mavlink_param, test_a_set_is_in_force_when_it_is_answered_and_handed_out_to_be_stored)
{
	receive(0, PARAM_SET_CURVE, sizeof(PARAM_SET_CURVE)); /* to 0; the default is 1 */
	zassert_equal(out.count, 1);
	assert_value(0, 0, PARAM_LGT_CURVE, 0);
	zassert_equal(device_params->values[PARAM_LGT_CURVE], 0);
	zassert_true(param_set_has(&effects.params, PARAM_LGT_CURVE));
	/* the same again: answered, but nothing to store */
	set(0, "LGT_CURVE", 0);
	assert_value(0, 0, PARAM_LGT_CURVE, 0);
	zassert_true(param_set_is_empty(&effects.params));
}

ZTEST(mavlink_param, test_a_name_of_16_characters_needs_no_terminator)
{
	static const char longer[] = "LGT_CURVE_AND_MORE";

	set(0, longer, 0);
	assert_error(0, "LGT_CURVE_AND_MO", -1, 1);
	zassert_equal(device_params->values[PARAM_LGT_CURVE], 1);
}

ZTEST(mavlink_param, test_a_refused_set_is_answered_by_why_and_by_what_is_in_force)
{
	set(0, "LGT_SRC_NOW", 1);
	zassert_equal(out.count, 2);
	assert_error(0, "LGT_SRC_NOW", -1, 5); /* READ_ONLY */
	assert_value(1, 0, PARAM_LGT_SRC_NOW, 0);
	set(0, "LGT_CURVE", 2);
	zassert_equal(out.count, 2);
	assert_error(0, "LGT_CURVE", -1, 2); /* VALUE_OUT_OF_RANGE */
	assert_value(1, 0, PARAM_LGT_CURVE, 1);
	set(0, "STRB_MIN", 16); /* in its range, but above STRB_MAX */
	assert_error(0, "STRB_MIN", -1, 2);
	assert_value(1, 0, PARAM_STRB_MIN, 0.01f);
	zassert_true(param_set_is_empty(&effects.params));
	zassert_equal(service.params.stats.refused, 3);
}

ZTEST(mavlink_param, test_every_integer_type_is_taken_bytewise)
{
	static const uint8_t one[4] = {1, 0xAA, 0xAA, 0xAA};
	static const uint8_t minus_one[4] = {0xFF, 0xAA, 0xAA, 0xAA};
	static const uint8_t minus_one_16[4] = {0xFF, 0xFF, 0xAA, 0xAA};
	static const uint8_t thousand[4] = {0xE8, 0x03, 0xAA, 0xAA}; /* 1000 */
	static const uint8_t million[4] = {0x40, 0x42, 0x0F, 0x00};  /* 1 000 000 */

	set_typed(0, "LGT_RESTORE", one, 1, 243); /* UINT8 */
	assert_value(0, 0, PARAM_LGT_RESTORE, 1);
	set_typed(0, "CAN_LIGHT_ID", minus_one, 2, 243); /* INT8 */
	assert_value(0, 0, PARAM_CAN_LIGHT_ID, -1);
	set_typed(0, "LGT_LOSS", thousand, 3, 243); /* UINT16 */
	assert_value(0, 0, PARAM_LGT_LOSS, 1000);
	zassert_equal(device_params->values[PARAM_LGT_LOSS], 1000000); /* ms */
	set_typed(0, "CAN_HARDPT_ID", minus_one_16, 4, 243);           /* INT16 */
	assert_value(0, 0, PARAM_CAN_HARDPT_ID, -1);
	set_typed(0, "SYNC_FILT", million, 5, 243); /* UINT32 */
	assert_value(0, 0, PARAM_SYNC_FILT, 1000000);
	set(0, "THR_SENS_MIN", -60); /* INT32 */
	assert_value(0, 0, PARAM_THR_SENS_MIN, -60);
	zassert_equal(device_params->values[PARAM_THR_SENS_MIN], -60000); /* mdegC */
}

ZTEST(mavlink_param, test_a_float_is_taken_in_its_unit_to_the_nearest_step)
{
	float value = 2.5f;

	set_typed(0, "STRB_MAX", &value, 9, 243); /* REAL32 */
	zassert_equal(out.count, 1);
	assert_value(0, 0, PARAM_STRB_MAX, 2.5f);
	zassert_equal(device_params->values[PARAM_STRB_MAX], 2500000); /* us */
	value = 2.00000049f;
	set_typed(0, "STRB_MAX", &value, 9, 243);
	zassert_equal(out.count, 1);
	assert_value(0, 0, PARAM_STRB_MAX, 2.0f); /* as taken, not as asked */
	value = 79.9996f;
	set_typed(0, "THR_THROTTLE", &value, 9, 243);
	assert_value(0, 0, PARAM_THR_THROTTLE, 80.0f);
	value = 1.0f;
	set_typed(0, "LGT_RESTORE", &value, 9, 243);
	assert_value(0, 0, PARAM_LGT_RESTORE, 1.0f);
	value = 0.0f;
	set_typed(0, "LGT_RESTORE", &value, 9, 243);
	for (int i = 0; i < 5; i++) {
		const float bad[] = {0.5f, NAN, INFINITY, -INFINITY, 2147483648.0f};

		value = bad[i];
		set_typed(0, "LGT_RESTORE", &value, 9, 243);
		zassert_equal(out.count, 2, "%d", i);
		assert_error(0, "LGT_RESTORE", -1, 2);
		assert_value(1, 0, PARAM_LGT_RESTORE, 0);
	}
}

ZTEST(mavlink_param, test_other_types_are_refused)
{
	static const uint8_t types[] = {0, 7, 8, 10, 11, 255}; /* 64 bits, double, none at all */
	static const uint8_t too_much[4] = {0, 0, 0, 0x80};    /* 2 147 483 648 as UINT32 */
	const int32_t value = 1;

	for (size_t i = 0; i < sizeof(types); i++) {
		set_typed(0, "LGT_RESTORE", &value, types[i], 243);
		zassert_equal(out.count, 2);
		assert_error(0, "LGT_RESTORE", -1, 6); /* TYPE_UNSUPPORTED */
		assert_value(1, 0, PARAM_LGT_RESTORE, 0);
	}
	set_typed(0, "THR_SENS_MIN", too_much, 5, 243);
	assert_error(0, "THR_SENS_MIN", -1, 2);
}

ZTEST(mavlink_param, test_a_nan_in_the_bytes_of_an_integer_is_its_bits)
{
	static const uint8_t quiet_nan[4] = {0, 0, 0xC0, 0x7F}; /* 2 143 289 344 */

	set_typed(0, "LGT_RESTORE", quiet_nan, 6, 243);
	assert_error(0, "LGT_RESTORE", -1, 2);
	assert_value(1, 0, PARAM_LGT_RESTORE, 0);
}

ZTEST(mavlink_param, test_version_1_gets_the_value_but_no_error)
{
	endpoint.links[0].version = 1;
	const struct mavlink_sender ground = {
		.version = 1, .sequence = 1, .system_id = 255, .component_id = 190};
	static const struct mavlink_kind kind = MAVLINK_KIND(PARAM_SET);
	const mavlink_param_set_t wire = {.target_system = 1,
	                                  .target_component = 243,
	                                  .param_id = "LGT_SRC_NOW",
	                                  .param_type = 6};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(0, bytes, mavlink_frame_build(bytes, &ground, &kind, &wire));
	zassert_equal(out.count, 1); /* 345 can't be said in version 1 */
	zassert_equal(sent(0).version, 1);
	assert_value(0, 0, PARAM_LGT_SRC_NOW, 0);
}

/* --- lists ------------------------------------------------------------------------------------ */

struct listing {
	uint32_t seen[PARAM_COUNT];
	uint32_t total;
	int64_t first_us;
	int64_t last_us;
	float last_value[PARAM_COUNT];
};

static void note(struct listing *listing, uint16_t i)
{
	mavlink_param_value_t wire;
	const uint32_t index = sent_value(i, &wire);

	zassert_equal(out.frames[i].length, VALUE_BYTES);
	listing->first_us = listing->total == 0 ? now_us : listing->first_us;
	listing->last_us = now_us;
	listing->total++;
	listing->seen[index]++;
	listing->last_value[index] = wire.param_value;
}

/* Until then; the values that went out, per link. */
static void run_lists(int64_t until_us, struct listing listings[2])
{
	while (mavlink_endpoint_deadline_us(&endpoint) <= until_us) {
		const int64_t due_us = mavlink_endpoint_deadline_us(&endpoint);

		now_us = due_us > now_us ? due_us : now_us;
		mavlink_endpoint_step(&endpoint, now_us, &out);
		for (uint16_t i = 0; i < out.count; i++) {
			if (sent(i).message_id == 22) {
				note(&listings[out.frames[i].link], i);
			}
		}
	}
	now_us = until_us;
}

static void assert_complete(const struct listing *listing, uint32_t times)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		zassert_equal(listing->seen[i], is_gimbals(i) ? 0 : times, "%s: %u times",
		              params_info(i)->name, listing->seen[i]);
	}
}

ZTEST(mavlink_param, test_a_list_is_paced_at_46_percent_of_57600_baud)
{
	struct listing listings[2] = {0};

	run_until(0);
	ask_list(0);
	zassert_equal(out.count, 0);
	run_lists(10 * SECOND, listings);
	assert_complete(&listings[0], 1);
	zassert_equal(listings[1].total, 0);
	zassert_equal(listings[0].first_us, 0);
	zassert_equal(listings[0].last_us, (int64_t)(COUNT - 1) * VALUE_TIME_US);
}

/* A ground station without a target asks everyone; each list is complete in itself. */
ZTEST(mavlink_param, test_both_components_list_what_is_theirs)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PARAM_REQUEST_LIST);
	const mavlink_param_request_list_t everyone = {0};
	const mavlink_param_request_list_t gimbal = {.target_system = 1, .target_component = 154};
	struct listing listings[2] = {0};

	add_gimbal();
	run_lists(0, listings);
	receive_message(0, &kind, &everyone);
	receive_message(1, &kind, &gimbal);
	run_lists(10 * SECOND, listings);
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		zassert_equal(listings[0].seen[i], 1);
		zassert_equal(listings[1].seen[i], is_gimbals(i) ? 1 : 0);
	}
	zassert_equal(listings[0].total, PARAM_COUNT);
	zassert_equal(listings[1].last_us, (int64_t)(GIMBALS_COUNT - 1) * VALUE_TIME_US);
}

ZTEST(mavlink_param, test_a_parameter_is_set_where_it_is)
{
	const float angle = -60.5f;
	struct listing listings[2] = {0};

	add_gimbal();
	run_lists(0, listings);
	set_typed(0, "GMB_PAN_MIN", &angle, 9, 243); /* it is not there */
	zassert_equal(out.count, 1);
	assert_error(0, "GMB_PAN_MIN", -1, 1);
	ask(0, "GMB_PAN_MIN", -1, 243);
	assert_error(0, "GMB_PAN_MIN", -1, 1);
	set_typed(0, "GMB_PAN_MIN", &angle, 9, 154);
	zassert_equal(out.count, 1);
	assert_value(0, 0, PARAM_GMB_PAN_MIN, -60.5f);
	zassert_equal(sent(0).component_id, 154);
	zassert_equal(device_params->values[PARAM_GMB_PAN_MIN], -60500);
	/* on the other link the one that has it tells of it, once */
	run_lists(SECOND / 2, listings);
	zassert_equal(listings[0].total, 0);
	zassert_equal(listings[1].total, 1);
	zassert_equal(listings[1].last_value[PARAM_GMB_PAN_MIN], -60.5f);
	/* whether there is a gimbal, the light says */
	ask(0, "GMB_ENABLE", -1, 154);
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).message_id, 345);
	zassert_equal(sent(0).component_id, 154);
	ask(0, "GMB_ENABLE", -1, 0);
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).component_id, 243);
}

ZTEST(mavlink_param, test_a_faster_link_lists_faster)
{
	struct listing listings[2] = {0};

	endpoint.config.rates[0] = 57600; /* ten times as fast */
	run_until(0);
	ask_list(0);
	run_lists(10 * SECOND, listings);
	assert_complete(&listings[0], 1);
	zassert_equal(listings[0].last_us, (int64_t)(COUNT - 1) * (VALUE_TIME_US / 10));
}

ZTEST(mavlink_param, test_a_late_step_does_not_slow_the_list)
{
	run_until(0);
	ask_list(0);
	for (int64_t i = 0; i < COUNT; i++) {
		zassert_equal(mavlink_endpoint_deadline_us(&endpoint), i * VALUE_TIME_US);
		mavlink_endpoint_step(&endpoint, i * VALUE_TIME_US + 1000, &out);
	}
	zassert_equal(endpoint.links[0].bulk_us, COUNT * VALUE_TIME_US);
}

ZTEST(mavlink_param, test_lists_on_two_links_go_at_the_same_time)
{
	struct listing listings[2] = {0};

	run_until(0);
	ask_list(0);
	ask_list(1);
	run_lists(10 * SECOND, listings);
	for (int link = 0; link < 2; link++) {
		assert_complete(&listings[link], 1);
		zassert_equal(listings[link].last_us, (int64_t)(COUNT - 1) * VALUE_TIME_US);
	}
}

ZTEST(mavlink_param, test_a_second_request_lists_everything_again_and_holds_nothing_back)
{
	struct listing listings[2] = {0};
	uint32_t rarest = UINT32_MAX;

	run_until(0);
	/* an impatient client asks ten times in the time of one list */
	for (int i = 0; i < 10; i++) {
		ask_list(0);
		run_lists((i + 1) * (int64_t)COUNT * VALUE_TIME_US / 10, listings);
	}
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (!is_gimbals(i) && listings[0].seen[i] < rarest) {
			rarest = listings[0].seen[i];
		}
	}
	zassert_true(rarest >= 1, "a parameter never came");
	run_lists(20 * SECOND, listings);
	zassert_true(listings[0].total <= 2 * COUNT);
}

ZTEST(mavlink_param, test_a_set_during_a_list_shows_in_what_is_still_to_come)
{
	struct listing listings[2] = {0};

	run_until(0);
	ask_list(0);
	run_lists(5 * VALUE_TIME_US, listings);
	set(0, "CAN_ACT_TILT", 17);
	assert_value(0, 0, PARAM_CAN_ACT_TILT, 17); /* at once, not in its turn */
	set(0, "LGT_CURVE", 0);                     /* has been listed already */
	run_lists(10 * SECOND, listings);
	assert_complete(&listings[0], 1);
	zassert_equal(listings[0].last_value[PARAM_CAN_ACT_TILT], 17);
	/* the other link hears of both as well */
	zassert_equal(listings[1].total, 2);
	zassert_equal(listings[1].last_value[PARAM_LGT_CURVE], 0);
}

ZTEST(mavlink_param, test_what_others_change_is_told_on_every_link)
{
	struct listing listings[2] = {0};
	const struct device_who who = {.way = SECURITY_WAY_SHELL};

	run_until(0);
	zassert_equal(pharos_device_set_param(&device, now_us, &who, PARAM_SYNC_POL, 1), PARAMS_OK);
	settle();
	run_lists(SECOND / 2, listings);
	for (int link = 0; link < 2; link++) {
		zassert_equal(listings[link].total, 1);
		zassert_equal(listings[link].last_value[PARAM_SYNC_POL], 1);
	}
}

ZTEST(mavlink_param, test_a_link_that_goes_ends_its_list)
{
	struct listing listings[2] = {0};

	run_until(0);
	ask_list(0);
	run_lists(5 * VALUE_TIME_US, listings);
	mavlink_endpoint_link_down(&endpoint, 0);
	run_lists(SECOND, listings);
	mavlink_endpoint_link_up(&endpoint, now_us, 0);
	run_lists(2 * SECOND, listings);
	zassert_equal(listings[0].total, 6);
}

ZTEST(mavlink_param, test_capabilities_announce_the_bytewise_encoding)
{
	mavlink_component_information_basic_t basic;

	zassert_equal(COMMAND(512, 396), MAV_RESULT_ACCEPTED);
	sent_payload(1, 396, &basic, sizeof(basic));
	zassert_equal(basic.capabilities & 16, 16);
}
