/* SPDX-License-Identifier: Apache-2.0 */
/* Entity parameters over the device's parameter table. */
#include <string.h>

#include <zephyr/ztest.h>

#include "peer.h"

static uint8_t buffer[512];
static struct imc_parameter_list asked;

static void before(void *fixture)
{
	device_start(NULL);
	asked = (struct imc_parameter_list){0};
}

ZTEST_SUITE(imc_parameters, NULL, NULL, before, NULL, NULL);

static void query(const char *entity)
{
	const struct imc_message message = {
		.id = IMC_QUERY_ENTITY_PARAMETERS,
		.query_entity_parameters = {.name = text(entity),
	                                    .visibility = text("user"),
	                                    .scope = text("global")},
	};

	send(&message);
}

static void want(const char *name, const char *value)
{
	const struct imc_entity_parameter parameter = {.name = text(name), .value = text(value)};

	zassert_true(imc_parameters_add(&asked, buffer, sizeof(buffer), &parameter));
}

static void set(const char *entity)
{
	const struct imc_message message = {
		.id = IMC_SET_ENTITY_PARAMETERS,
		.entity_parameters = {.name = text(entity), .params = asked},
	};

	send(&message);
}

/* The answer's value of a parameter; "" with *length 0: it isn't in it. */
static bool answered(const char *name, const char *value)
{
	for (uint32_t i = 0; i < count(IMC_ENTITY_PARAMETERS); i++) {
		struct imc_parameter_list list =
			sent(IMC_ENTITY_PARAMETERS, i)->message.entity_parameters.params;
		struct imc_entity_parameter parameter;

		while (imc_parameters_next(&list, &parameter)) {
			if (imc_text_is(&parameter.name, name)) {
				return imc_text_is(&parameter.value, value);
			}
		}
	}
	return false;
}

static uint16_t answered_count(void)
{
	return sent(IMC_ENTITY_PARAMETERS, 0)->message.entity_parameters.params.count;
}

ZTEST(imc_parameters, test_query_tells_the_values_in_force)
{
	params->values[PARAM_THR_SENS_MIN] = -55000;
	params->values[PARAM_THR_HYST] = 0;
	params->values[PARAM_THR_NOISE] = 1250;
	query("Thermal");
	zassert_true(imc_text_is(&sent(IMC_ENTITY_PARAMETERS, 0)->message.entity_parameters.name,
	                         "Thermal"));
	zassert_equal(sent(IMC_ENTITY_PARAMETERS, 0)->header.src_ent, IMC_ENTITY_THERMAL);
	zassert_true(answered("THR_SENS_MIN", "-55"));
	zassert_true(answered("THR_HYST", "0"));
	zassert_true(answered("THR_NOISE", "1.25"));
	zassert_true(answered("THR_SHUTDOWN", "100"));
	zassert_false(answered("LGT_CURVE", "1"), "it is the lamp's");
}

/* Every parameter belongs to one entity, and its name leads to it. */
ZTEST(imc_parameters, test_all_parameters_are_there)
{
	uint32_t total = 0;

	for (uint32_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		query(imc_entity_name((enum imc_entity)i));
		for (uint32_t k = 0; k < count(IMC_ENTITY_PARAMETERS); k++) {
			total += sent(IMC_ENTITY_PARAMETERS, k)
			                 ->message.entity_parameters.params.count;
		}
	}
	zassert_equal(total, PARAM_COUNT);
}

ZTEST(imc_parameters, test_unknown_entities_are_not_answered)
{
	query("Lamp 2");
	zassert_equal(out.packets_count, 0);
	want("LGT_CURVE", "0");
	set("lamp");
	zassert_equal(out.packets_count, 0);
	zassert_equal(endpoint.node.stats.unknown_names, 2);
}

ZTEST(imc_parameters, test_without_a_name_the_header_says_which_entity)
{
	header.dst_ent = IMC_ENTITY_LAMP;
	query("");
	zassert_true(answered("LGT_CURVE", "1"));
	header.dst_ent = IMC_ENTITY_ALL;
	query("");
	zassert_equal(out.packets_count, 0);
}

/* IMC: 804 is answered with only what was accepted. */
ZTEST(imc_parameters, test_set_answers_what_was_accepted)
{
	want("LGT_CURVE", "0");
	want("LGT_CURVES", "0");   /* there is none */
	want("THR_HYST", "1");     /* another entity's */
	want("LGT_FALLBACK", "3"); /* out of range */
	want("LGT_SRC_NOW", "1");  /* read only */
	want("LGT_LOSS", "1e3");   /* no decimal number */
	want("LGT_SRC_HOLD", "1.50");
	set("Lamp");
	zassert_equal(answered_count(), 2);
	zassert_true(answered("LGT_CURVE", "0"));
	zassert_true(answered("LGT_SRC_HOLD", "1.5"));
	zassert_equal(params->values[PARAM_LGT_CURVE], 0);
	zassert_equal(params->values[PARAM_LGT_SRC_HOLD], 1500);
	zassert_equal(endpoint.node.stats.params_refused, 5);
	zassert_true(param_set_has(&effects.params, PARAM_LGT_CURVE));
	zassert_true(param_set_has(&effects.params, PARAM_LGT_SRC_HOLD));
	zassert_false(param_set_has(&effects.params, PARAM_THR_HYST));
}

ZTEST(imc_parameters, test_nothing_accepted_is_an_empty_answer)
{
	want("LGT_CURVE", "7");
	set("Lamp");
	zassert_equal(answered_count(), 0);
	zassert_true(param_set_is_empty(&effects.params));
}

ZTEST(imc_parameters, test_the_same_value_again_is_accepted_and_changes_nothing)
{
	want("LGT_CURVE", "1");
	set("Lamp");
	zassert_equal(answered_count(), 1);
	zassert_true(param_set_is_empty(&effects.params));
}

ZTEST(imc_parameters, test_which_texts_are_numbers)
{
	static const struct {
		const char *text;
		bool accepted;
		int32_t value; /* mdegC */
	} rows[] = {
		{"-55.001", true, -55001},
		{"-55.", true, -55000},
		{"-55.000", true, -55000},
		{"-55.00149", true, -55001}, /* the nearest step */
		{"0", true, 0},
		{"-0", true, 0},
		{"000012", true, 12000},
		{"true", true, 1000},
		{"false", true, 0},
		{"1.5", true, 1500},
		{"1000", true, 1000000}, /* the greatest that it takes */
		{"1000.001", false, 0},
		{"", false, 0},
		{"-", false, 0},
		{"+1", false, 0},
		{" 1", false, 0},
		{"1 ", false, 0},
		{".5", false, 0},
		{"0x10", false, 0},
		{"2147483648", false, 0},
		{"-2147483649", false, 0},
		{"4294967296", false, 0},
		{"99999999999999999999999999", false, 0},
		{"True", false, 0},
	};

	for (size_t i = 0; i < ARRAY_SIZE(rows); i++) {
		const bool of_max = rows[i].value > 150000 || !rows[i].accepted;

		device_start(NULL);
		asked = (struct imc_parameter_list){0};
		params->values[PARAM_THR_SENS_MIN] = -200000;
		params->values[PARAM_THR_SENS_MAX] = 1000000;
		want(of_max ? "THR_SENS_MAX" : "THR_SENS_MIN", rows[i].text);
		set("Thermal");
		zassert_equal(answered_count(), rows[i].accepted ? 1 : 0, "\"%s\"", rows[i].text);
		zassert_true(
			!rows[i].accepted ||
				params->values[of_max ? PARAM_THR_SENS_MAX : PARAM_THR_SENS_MIN] ==
					rows[i].value,
			"\"%s\"", rows[i].text);
	}
}

ZTEST(imc_parameters, test_a_choice_has_no_fraction)
{
	want("LGT_FALLBACK", "1.5");
	set("Lamp");
	zassert_equal(answered_count(), 0);
	want("LGT_FALLBACK", "2.0");
	set("Lamp");
	zassert_true(answered("LGT_FALLBACK", "2"));
}
