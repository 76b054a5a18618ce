/* SPDX-License-Identifier: Apache-2.0 */
#include "core/security.h"

#include "core/assert.h"

#define RIGHT(name_) (1u << SECURITY_##name_)

#define LOOK  (RIGHT(READ))
#define LAMP  (RIGHT(EXIST) | RIGHT(LIGHT) | RIGHT(GIMBAL) | RIGHT(OUTPUTS))
#define MIND  (RIGHT(PARAMS) | RIGHT(SUPERVISION) | RIGHT(RESTART) | RIGHT(UPDATE))
#define LOCKS (RIGHT(LOCK) | RIGHT(KEY))

/*
 * What a way may do at the most; while there is a key; and while its source is excluded. DroneCAN's
 * and IMC's row with a key is that of their grant.
 */
static const struct {
	uint32_t open;
	uint32_t keyed;
	uint32_t excluded;
} rows[SECURITY_WAYS] = {
	[SECURITY_WAY_MAVLINK] = {LOOK | LAMP | MIND | LOCKS, 0, LOOK},
	[SECURITY_WAY_MAVLINK_SIGNED] = {LOOK | LAMP | MIND | LOCKS, LOOK | LAMP | MIND | LOCKS,
                                         LOOK},
	[SECURITY_WAY_DRONECAN] = {LOOK | LAMP | MIND | RIGHT(LOCK), 0, LOOK},
	[SECURITY_WAY_IMC] = {LOOK | LAMP | MIND | RIGHT(LOCK), 0, LOOK},
	[SECURITY_WAY_SHELL] = {LOOK | LAMP | MIND | LOCKS, LOOK | LAMP | MIND | LOCKS,
                                LOOK | LOCKS | RIGHT(RESTART)},
	[SECURITY_WAY_BUTTON] = {RIGHT(EXIST) | RIGHT(LIGHT), RIGHT(EXIST) | RIGHT(LIGHT), 0},
};

static const uint32_t grants[] = {
	[SECURITY_GRANT_NOTHING] = LOOK,
	[SECURITY_GRANT_LIGHT] = LOOK | LAMP,
	[SECURITY_GRANT_ALL] = LOOK | LAMP | MIND,
};

enum arbiter_source security_source(enum security_way way)
{
	static const enum arbiter_source sources[SECURITY_WAYS] = {
		[SECURITY_WAY_MAVLINK] = ARBITER_SOURCE_MAVLINK,
		[SECURITY_WAY_MAVLINK_SIGNED] = ARBITER_SOURCE_MAVLINK,
		[SECURITY_WAY_DRONECAN] = ARBITER_SOURCE_DRONECAN,
		[SECURITY_WAY_IMC] = ARBITER_SOURCE_IMC,
		[SECURITY_WAY_SHELL] = ARBITER_SOURCE_SHELL,
		[SECURITY_WAY_BUTTON] = ARBITER_SOURCE_SHELL,
	};

	PHAROS_ASSERT(way < SECURITY_WAYS);
	return sources[way];
}

static uint32_t keyed(const struct security *self, enum security_way way)
{
	if (way == SECURITY_WAY_DRONECAN) {
		return grants[self->dronecan];
	}
	if (way == SECURITY_WAY_IMC) {
		return grants[self->imc];
	}
	return rows[way].keyed;
}

enum security_verdict security_check(const struct security *self, enum security_way way,
                                     enum security_right right)
{
	PHAROS_ASSERT(way < SECURITY_WAYS && right < SECURITY_RIGHTS);
	const uint32_t bit = 1u << right;

	if ((rows[way].open & bit) == 0) {
		return SECURITY_FORBIDDEN;
	}
	if ((self->excluded & ARBITER_SOURCE_BIT(security_source(way))) != 0 &&
	    (rows[way].excluded & bit) == 0) {
		return SECURITY_EXCLUDED;
	}
	if (self->has_key && (keyed(self, way) & bit) == 0) {
		return SECURITY_NO_KEY;
	}
	return SECURITY_GRANTED;
}
