/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who may do what: one table of ways in and rights, for every protocol. docs/security.md shows it.
 *
 * A way is how a request reached the device, and whether it proved to have the key. A right is what
 * it wants to do. Three things decide: the way, whether the device has a key, and whether the way's
 * source is excluded (LGT_SRC_EXCL).
 *
 * Without a key everybody who is not excluded may do everything, but the key comes only over a
 * secure link or the console. With a key, what is unsigned may do nothing; DroneCAN and IMC, which
 * have no signatures, may do what MAV_KEY_CAN and MAV_KEY_IMC say. An excluded source may look, no
 * more; but the console can always change exclusion and key, and restart, so that nobody is locked
 * out for good.
 *
 * Context: any; nothing here changes anything.
 */
#ifndef PHAROS_CORE_SECURITY_H
#define PHAROS_CORE_SECURITY_H

#include "core/arbiter.h"

#include <stdbool.h>
#include <stdint.h>

/* How a request came. A tunnel's MAVLink is MAVLink: signed, or not. */
enum security_way {
	SECURITY_WAY_MAVLINK,        /* unsigned */
	SECURITY_WAY_MAVLINK_SIGNED, /* rightly signed with the device's key */
	SECURITY_WAY_DRONECAN,
	SECURITY_WAY_IMC,
	SECURITY_WAY_SHELL,  /* the local console */
	SECURITY_WAY_BUTTON, /* on the housing; excluded with the shell */
	SECURITY_WAYS,
};

enum security_right {
	SECURITY_READ,        /* questions that change nothing */
	SECURITY_EXIST,       /* be a sign of life, give the system id, make a route */
	SECURITY_LIGHT,       /* the lamp, and tests of it */
	SECURITY_GIMBAL,      /* where the beam points */
	SECURITY_OUTPUTS,     /* power channels, PWM, lines, LEDs, thruster, zoom, display */
	SECURITY_PARAMS,      /* parameters, but those of the next two */
	SECURITY_SUPERVISION, /* limits of heat, ids, priorities, link loss, routing */
	SECURITY_LOCK,        /* exclusion, secure links, what goes without a signature */
	SECURITY_KEY,         /* set or remove the key; over MAVLink on a secure link only */
	SECURITY_RESTART,
	SECURITY_UPDATE, /* of the firmware */
	SECURITY_RIGHTS,
};

/* What a protocol without signatures may do while there is a key: MAV_KEY_CAN, MAV_KEY_IMC. */
enum security_grant {
	SECURITY_GRANT_NOTHING, /* but look */
	SECURITY_GRANT_LIGHT,   /* lamp, gimbal, outputs */
	SECURITY_GRANT_ALL,     /* all but lock and key */
};

enum security_verdict {
	SECURITY_GRANTED,
	SECURITY_EXCLUDED,  /* the source is excluded by parameter */
	SECURITY_NO_KEY,    /* the device has a key, and this did not prove to have it */
	SECURITY_FORBIDDEN, /* this way never has that right */
};

/* excluded: ARBITER_SOURCE_BITs. */
struct security {
	bool has_key;
	uint32_t excluded;
	enum security_grant dronecan;
	enum security_grant imc;
};

/* way and right within their enums (asserted), here and below. */
enum security_verdict security_check(const struct security *self, enum security_way way,
                                     enum security_right right);

/* Whom a way counts as in the arbiter. */
enum arbiter_source security_source(enum security_way way);

#endif
