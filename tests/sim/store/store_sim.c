/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The store alone, with power cut at every byte of every write.
 *
 *	store_sim [--cuts N] [--seed S]
 *
 * Each run accepts random changes, one or several at a time, at random times, and writes what
 * core/store wants written through the native settings onto a flash of words of 4, 8 or 32 bytes.
 * Each write is cut after 0, 1, … bytes; the word that was only begun is then as it came, erased,
 * garbage, or unreadable. After each cut the device starts anew, and must have the state after a
 * prefix of what was accepted, with everything in it that was accepted before the bound; and it
 * must be able to store the next change. Some cuts are where the run goes on from.
 *
 * Every other run has, instead of the native settings, two places that are written byte by byte, as
 * a store would have that is not atomic and has no checksums of its own: a cut leaves the beginning
 * of the new value, and of the old one at most its end.
 *
 * Beside cuts, content is damaged anywhere: then it is a state that was accepted, or one that is no
 * warmer than the defaults and dark.
 *
 * The oracle is a list of what was accepted. It knows nothing of records, slots or settling.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/assert.h"
#include "core/store.h"
#include "subsys/settings/settings_records.h"

#include "torn_flash.h"

#undef main /* not an application's */

#define MS INT64_C(1000)
#define S  INT64_C(1000000)

#define WRITE_MAX_US (200 * MS)
/* How long a change may be missing after a cut: a write may be under way, then comes its own. */
#define BOUND_US     (2 * WRITE_MAX_US)
/* The light settles: "30 s", and 36 s where it never stands still. */
#define LIGHT_US     (36 * S)

#define CHANGES_MAX 40

void pharos_assert_failed(const char *file, int line)
{
	printf("assertion failed: %s:%d\n", file, line);
	abort();
}

/* --- the oracle: what was accepted, in order -------------------------------------------------- */

struct accepted {
	int32_t values[PARAM_COUNT];
	int64_t light[5];
	int power; /* -1: none */
	bool has_light;
	bool has_signing;
	uint8_t signing[STORE_SIGNING_BYTES];
	int64_t at_us;
	bool settles;
};

static struct accepted history[CHANGES_MAX + 2];
static size_t count; /* history[0] is the state at the start */

static bool is_state(const struct accepted *wanted, const struct store_state *state)
{
	const struct illuminator_settings *const light = &state->light;

	if (memcmp(wanted->values, state->params.values, sizeof(wanted->values)) != 0 ||
	    wanted->has_light != state->has_light || wanted->has_signing != state->has_signing ||
	    wanted->power != (state->has_power ? state->power : -1)) {
		return false;
	}
	if (wanted->has_light &&
	    (wanted->light[0] != light->enable || wanted->light[1] != (int64_t)light->mode ||
	     wanted->light[2] != light->brightness_ppm ||
	     wanted->light[3] != light->strobe_period_us || wanted->light[4] != light->duty_ppm)) {
		return false;
	}
	return !wanted->has_signing ||
	       memcmp(wanted->signing, state->signing, STORE_SIGNING_BYTES) == 0;
}

static const enum param_id chain[] = {PARAM_THR_SENS_MIN, PARAM_THR_RECOVER, PARAM_THR_THROTTLE,
                                      PARAM_THR_SHUTDOWN, PARAM_THR_SENS_MAX};

static bool rules_hold(const int32_t values[PARAM_COUNT])
{
	for (size_t i = 1; i < sizeof(chain) / sizeof(chain[0]); i++) {
		if (values[chain[i - 1]] >= values[chain[i]]) {
			return false;
		}
	}
	return values[PARAM_STRB_MIN] <= values[PARAM_STRB_MAX] &&
	       values[PARAM_GMB_PAN_MIN] < values[PARAM_GMB_PAN_MAX] &&
	       values[PARAM_GMB_TLT_MIN] < values[PARAM_GMB_TLT_MAX];
}

/* --- the device ------------------------------------------------------------------------------- */

static struct store store;
static struct settings_records records;
static int64_t now_us;

static const char *const names[STORE_SLOTS] = {"pharos/0", "pharos/1"};

static bool bare; /* the two places, not the native settings */

/* False: there is nothing in that slot, or nothing that can be read. */
static bool read_slot(struct settings_records *from, uint8_t slot, struct settings_record *record)
{
	if (!bare) {
		return settings_records_find(from, names[slot], record);
	}
	record->value = torn_flash_place(slot, &record->value_length);
	return record->value_length > 0;
}

/* Power comes back: what the device makes of what the flash holds. */
static void boot(struct store *into, struct settings_records *from)
{
	struct settings_record record;
	int whole = 0;

	torn_flash.bytes_left = SIZE_MAX;
	store_init(into);
	if (!bare && settings_records_open(from, &torn_flash_medium) != 0) {
		return;
	}
	for (uint8_t slot = 0; slot < STORE_SLOTS; slot++) {
		if (read_slot(from, slot, &record)) {
			whole += store_offer(into, slot, record.value, record.value_length) ? 1 : 0;
		}
	}
	for (uint8_t slot = 0; slot < STORE_SLOTS && whole == 0; slot++) {
		if (read_slot(from, slot, &record)) {
			store_salvage(into, record.value, record.value_length);
		}
	}
	(void)store_check(into);
}

static bool write_record(struct settings_records *to, const uint8_t *record, size_t length,
                         uint8_t slot)
{
	return bare ? torn_flash_put(slot, record, length)
	            : settings_records_save(to, names[slot], record, length) == 0;
}

/* --- what goes wrong -------------------------------------------------------------------------- */

static uint64_t seed;
static uint64_t runs;
static uint64_t cuts;
static uint64_t cuts_by_word[33];
static uint64_t cuts_bare;
static uint64_t unreadable;
static uint64_t damages;
static uint64_t writes;
static uint64_t prefixes_older; /* cuts that left the state before the write */

static void fail(const char *what, size_t cut)
{
	printf("store_sim: %s; again: --seed %" PRIu64 " --cuts 1 (run %" PRIu64
	       ", word %zu, torn %d, "
	       "after %zu bytes, change %zu)\n",
	       what, seed, runs, torn_flash.word, (int)torn_flash.torn, cut, count - 1);
	exit(1);
}

/* Index of the newest accepted state that this is; SIZE_MAX: none. */
static size_t find(const struct store_state *state)
{
	for (size_t i = count; i-- > 0;) {
		if (is_state(&history[i], state)) {
			return i;
		}
	}
	return SIZE_MAX;
}

/* The oldest state that may be left at this instant. */
static size_t bound(size_t last_stored)
{
	for (size_t i = count; i-- > last_stored;) {
		const int64_t may_us = BOUND_US + (history[i].settles ? LIGHT_US : 0);

		if (now_us - history[i].at_us > may_us) {
			return i;
		}
	}
	return last_stored;
}

/* A new change is stored, and there after another reset. */
static void check_works_on(struct store *again, struct settings_records *on, size_t cut)
{
	uint8_t record[STORE_RECORD_MAX];
	uint8_t slot;
	const uint8_t mask = (uint8_t)(again->state.power + 1);

	store_power(again, 0, mask);

	const size_t length = store_begin(again, 0, record, &slot);

	if (length == 0 || !write_record(on, record, length, slot)) {
		fail("it cannot store the next change", cut);
	}
	boot(again, on);
	if (!again->state.has_power || again->state.power != mask) {
		fail("the next change is not there", cut);
	}
}

static void check_after_cut(size_t last_stored, size_t cut)
{
	static struct store again;
	static struct settings_records on;
	const struct torn_content kept = torn_flash.content;

	boot(&again, &on);

	const size_t found = find(&again.state);

	if (found == SIZE_MAX) {
		fail("a state that was never accepted", cut);
	}
	if (found < bound(last_stored)) {
		fail("a change that should be stored is not", cut);
	}
	if (!rules_hold(again.state.params.values)) {
		fail("a rule does not hold", cut);
	}
	prefixes_older += found < count - 1 ? 1 : 0;
	check_works_on(&again, &on, cut);
	torn_flash.content = kept;
}

/* Bits turn, or a word cannot be read any more, anywhere. */
static void check_after_damage(void)
{
	static struct store again;
	static struct settings_records on;
	const struct torn_content kept = torn_flash.content;

	if (torn_flash.content.length == 0) {
		return;
	}
	for (uint64_t n = 1 + draw(8); n > 0; n--) {
		torn_flash.content.bytes[draw(torn_flash.content.length)] ^=
			(uint8_t)(1 << draw(8));
	}
	if (draw(2) == 0) {
		torn_flash.content.lost_size = torn_flash.word;
		torn_flash.content.lost_at =
			draw(torn_flash.content.length) / torn_flash.word * torn_flash.word;
	}
	boot(&again, &on);
	damages++;
	if (!rules_hold(again.state.params.values)) {
		fail("damage broke a rule", 0);
	}
	if (find(&again.state) == SIZE_MAX) {
		for (uint32_t i = 0; i < PARAM_COUNT; i++) {
			const bool heat = i == PARAM_THR_RECOVER || i == PARAM_THR_THROTTLE ||
			                  i == PARAM_THR_SHUTDOWN || i == PARAM_THR_FLOOR ||
			                  i == PARAM_THR_SAFE || i == PARAM_THR_SLEW;

			if (heat && again.state.params.values[i] > params_info(i)->fallback) {
				fail("damage made it warmer", 0);
			}
		}
		if (again.state.has_light) {
			fail("damage lit it", 0);
		}
	}
	torn_flash.content = kept;
}

/* --- a run ------------------------------------------------------------------------------------ */

static struct accepted *next_accepted(bool settles)
{
	struct accepted *const next = &history[count];

	*next = history[count - 1];
	next->at_us = now_us;
	next->settles = settles;
	count++;
	return next;
}

static int64_t between(int64_t low, int64_t high)
{
	return low + (int64_t)draw((uint64_t)(high - low + 1));
}

static int32_t any_value(uint32_t index)
{
	const struct param_info *const info = params_info(index);

	switch (draw(4)) {
	case 0:
		return info->fallback;
	case 1:
		return draw(2) == 0 ? info->min : info->max;
	default:
		return (int32_t)between(info->min, info->max);
	}
}

/* The limits of heat, all at once. */
static void draw_limits(struct params *params, struct param_set *set)
{
	int32_t limit = -55000;

	params->values[PARAM_THR_SENS_MIN] = limit;
	limit = -40001;
	for (size_t i = 1; i <= 3; i++) {
		limit = (int32_t)between(limit + 1, 149990 + (int64_t)i);
		params->values[chain[i]] = limit;
	}
	params->values[PARAM_THR_SENS_MAX] = 150000;
	for (size_t i = 0; i < sizeof(chain) / sizeof(chain[0]); i++) {
		param_set_add(set, chain[i]);
	}
}

/* Several parameters together, or one. Nothing is accepted when a rule would not hold. */
static void change_params(void)
{
	struct params params;
	struct param_set set = {0};
	const uint64_t kind = draw(4);
	size_t size = kind == 0 ? 1 : 1 + draw(12);

	memcpy(params.values, history[count - 1].values, sizeof(params.values));
	if (kind == 3) {
		draw_limits(&params, &set);
		size = 0;
	}
	for (; size > 0; size--) {
		const uint32_t index = (uint32_t)draw(PARAM_COUNT);

		if ((params_info(index)->flags & PARAM_FLAG_READ_ONLY) == 0) {
			params.values[index] = any_value(index);
			param_set_add(&set, index);
		}
	}
	if (rules_hold(params.values)) {
		memcpy(next_accepted(false)->values, params.values, sizeof(params.values));
		store_params(&store, now_us, &params, &set);
	}
}

static void change_light(void)
{
	const struct illuminator_settings light = {
		.enable = draw(2) == 0,
		.mode = draw(2) == 0 ? ILLUMINATOR_MODE_INTERNAL : ILLUMINATOR_MODE_SYNC,
		.brightness_ppm = (uint32_t)draw(1000001),
		.strobe_period_us = (uint32_t)draw(60000001),
		.duty_ppm = (uint32_t)draw(1000001),
	};
	struct accepted *const next = next_accepted(true);

	next->has_light = true;
	next->light[0] = light.enable;
	next->light[1] = light.mode;
	next->light[2] = light.brightness_ppm;
	next->light[3] = light.strobe_period_us;
	next->light[4] = light.duty_ppm;
	store_light(&store, now_us, &light);
}

static void change_rest(void)
{
	struct accepted *const next = next_accepted(false);

	if (draw(2) == 0) {
		next->power = (int)draw(255) + 1; /* what holds and is not stored is 0 */
		store_power(&store, now_us, (uint8_t)next->power);
		return;
	}
	next->has_signing = true;
	for (size_t i = 0; i < STORE_SIGNING_BYTES; i++) {
		next->signing[i] = (uint8_t)draw(256);
	}
	store_signing(&store, now_us, next->signing);
}

/* What changed nothing was no change. */
static void forget_nothing(void)
{
	struct accepted *const last = &history[count - 1];
	struct accepted before;

	if (count < 2) {
		return;
	}
	before = history[count - 2];
	before.at_us = last->at_us;
	before.settles = last->settles;
	count -= memcmp(&before, last, sizeof(before)) == 0 ? 1 : 0;
}

static void change(void)
{
	const uint64_t kind = draw(8);

	if (kind < 4) {
		change_params();
	} else if (kind < 7) {
		change_light();
	} else {
		change_rest();
	}
	forget_nothing();
}

static int64_t next_change_us(void)
{
	static const int64_t gaps_us[] = {0, 10 * MS, 400 * MS, 3 * S, 40 * S};

	return now_us + (int64_t)draw((uint64_t)gaps_us[draw(5)] + 1);
}

/* One write that is due, cut at every byte. Returns how much of the history is stored after it. */
static size_t write_due(size_t last_stored)
{
	static struct torn_content flash_before;
	static struct settings_records records_before;
	uint8_t record[STORE_RECORD_MAX];
	uint8_t slot;
	const size_t length = store_begin(&store, now_us, record, &slot);
	const size_t begun = count - 1;
	size_t total;
	bool may_cut;

	flash_before = torn_flash.content;
	records_before = records;
	torn_flash.programmed = 0;
	if (length == 0 || !write_record(&records, record, length, slot)) {
		fail("a write that is due does not happen", 0);
	}
	total = torn_flash.programmed;
	writes++;
	/* Without settings the very first record has none before it to fall back on. */
	may_cut = !bare || store.sequence > 0;
	for (size_t cut = 0; cut < total && may_cut; cut++) {
		torn_flash.torn = (enum torn)draw(TORN_COUNT);
		torn_flash.content = flash_before;
		records = records_before;
		torn_flash.bytes_left = cut;
		if (write_record(&records, record, length, slot)) {
			fail("a cut that does not cut", cut);
		}
		cuts++;
		cuts_by_word[torn_flash.word]++;
		cuts_bare += bare ? 1 : 0;
		unreadable += torn_flash.content.lost_size > 0 ? 1 : 0;
		check_after_cut(last_stored, cut);
	}
	/* Mostly on without a cut. */
	torn_flash.content = flash_before;
	records = records_before;
	torn_flash.bytes_left = may_cut && draw(6) == 0 ? draw(total) : SIZE_MAX;
	torn_flash.torn = (enum torn)draw(TORN_COUNT);

	const bool stored = write_record(&records, record, length, slot);
	const bool is_cut = torn_flash.bytes_left != SIZE_MAX && !stored;

	now_us += between(1, WRITE_MAX_US);
	if (is_cut) {
		boot(&store, &records);
		count = find(&store.state) + 1;
		if (count == 0) {
			fail("a state that was never accepted", 0);
		}
		return count - 1;
	}
	torn_flash.bytes_left = SIZE_MAX;
	/* What comes while it is written. */
	for (uint64_t n = draw(3); n > 0 && count < CHANGES_MAX; n--) {
		change();
	}
	store_done(&store, now_us, true);
	check_after_cut(begun, total);
	check_after_damage();
	return begun;
}

static void run(void)
{
	static const size_t words[] = {4, 8, 32};
	size_t last_stored = 0;
	int64_t change_us;

	torn_flash.word = words[seed % 3];
	bare = seed / 3 % 2 == 1;
	memset(&torn_flash.content, 0, sizeof(torn_flash.content));
	memset(&history[0], 0, sizeof(history[0]));
	history[0].power = -1;
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		history[0].values[i] = params_info(i)->fallback;
	}
	count = 1;
	now_us = 0;
	boot(&store, &records);
	change_us = next_change_us();
	for (int step = 0; step < 80 && count < CHANGES_MAX; step++) {
		const int64_t due_us = store_deadline_us(&store);

		if (due_us <= change_us) {
			now_us = due_us > now_us ? due_us : now_us;
			last_stored = write_due(last_stored);
		} else {
			now_us = change_us > now_us ? change_us : now_us;
			change();
			change_us = next_change_us();
		}
	}
	runs++;
}

int main(int argc, char *argv[])
{
	uint64_t wanted = 20000;

	seed = 1;
	for (int i = 1; i + 1 < argc; i += 2) {
		if (strcmp(argv[i], "--cuts") == 0) {
			wanted = strtoull(argv[i + 1], NULL, 10);
		} else if (strcmp(argv[i], "--seed") == 0) {
			seed = strtoull(argv[i + 1], NULL, 10);
		} else {
			fprintf(stderr, "store_sim [--cuts N] [--seed S]\n");
			return 2;
		}
	}
	printf("store_sim --cuts %" PRIu64 " --seed %" PRIu64 "\n", wanted, seed);
	const uint64_t first = seed;

	for (; cuts < wanted; seed++) {
		chance_seed(seed);
		run();
	}
	printf("%" PRIu64 " runs, %" PRIu64 " writes, %" PRIu64 " cuts (words of 4: %" PRIu64
	       ", 8: %" PRIu64 ", 32: %" PRIu64 "; %" PRIu64 " without settings), %" PRIu64
	       " left a word unreadable, %" PRIu64 " left an older state, %" PRIu64
	       " damages; none off\n",
	       runs, writes, cuts, cuts_by_word[4], cuts_by_word[8], cuts_by_word[32], cuts_bare,
	       unreadable, prefixes_older, damages);
	return first == seed ? 1 : 0;
}
