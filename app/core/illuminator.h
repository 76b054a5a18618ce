/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The illuminator: what was commanded, what the lamp shall do, what people should be told.
 *
 * Every event is decided whole and then applied whole: a result other than ACCEPTED changed
 * nothing. A repeated command is ACCEPTED and advances nothing. Commanded values are kept as they
 * came; heat limits the lamp in the light driver, not here.
 *
 * Context: the thread that owns it, no locks inside. Spec: MAVLink common 405, 406, 440.
 */
#ifndef PHAROS_CORE_ILLUMINATOR_H
#define PHAROS_CORE_ILLUMINATOR_H

#include "core/light.h"
#include "core/limits.h"
#include "core/thermal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Wire values of MAVLink ILLUMINATOR_MODE; SYNC is its EXTERNAL_SYNC, a name the dialect takes. */
enum illuminator_mode {
	ILLUMINATOR_MODE_INTERNAL = 1,
	ILLUMINATOR_MODE_SYNC = 2,
};
#define ILLUMINATOR_MODES_SUPPORTED 3u /* bit per mode: 1 << (mode - 1) */

/* How brightness becomes light. PERCEPTUAL: CIE 1931 lightness, L* = brightness in percent. */
enum illuminator_curve {
	ILLUMINATOR_CURVE_LINEAR,
	ILLUMINATOR_CURVE_PERCEPTUAL,
};

/* What to do when every commander is silent. BEACON: the strobe of the configuration. */
enum illuminator_fallback {
	ILLUMINATOR_FALLBACK_KEEP,
	ILLUMINATOR_FALLBACK_OFF,
	ILLUMINATOR_FALLBACK_BEACON,
};

/*
 * As commanded. brightness_ppm, duty_ppm 0…PPM_ONE. strobe_period_us 0: no strobe. duty_ppm 0: no
 * strobe either; PPM_ONE: constantly on.
 */
struct illuminator_settings {
	bool enable;
	enum illuminator_mode mode;
	uint32_t brightness_ppm;
	uint32_t strobe_period_us;
	uint32_t duty_ppm;
};

/* period_us: brought between the shortest and the longest of the configuration. */
struct illuminator_beacon {
	uint32_t period_us;
	uint32_t duty_ppm;
	uint32_t brightness_ppm;
};

/*
 * STROBE_PERIOD_FLOOR_US <= min_period_us <= max_period_us <= STROBE_PERIOD_CEILING_US, ratios
 * 0…PPM_ONE, program valid: asserted. The program shows while the lamp is on in internal mode and
 * no strobe period is commanded.
 */
struct illuminator_config {
	uint32_t min_period_us;
	uint32_t max_period_us;
	enum illuminator_curve curve;
	struct illuminator_beacon beacon;
	struct program program;
};

/* Commands first, up to TEST. */
enum illuminator_event_kind {
	ILLUMINATOR_EVENT_ON_OFF,     /* on_off */
	ILLUMINATOR_EVENT_CONFIGURE,  /* configure: all of 406, enable stays */
	ILLUMINATOR_EVENT_BRIGHTNESS, /* brightness_ppm, the rest stays */
	ILLUMINATOR_EVENT_RESTORE,    /* restore: settings saved before, enable too */
	ILLUMINATOR_EVENT_TEST,       /* test: what the lamp shows meanwhile, or no more */
	ILLUMINATOR_EVENT_THERMAL,    /* thermal: a new report */
	ILLUMINATOR_EVENT_CONFIG,     /* config: new parameters; settings in force stay */
	ILLUMINATOR_EVENT_FALLBACK,   /* fallback: every commander is silent */
	ILLUMINATOR_EVENT_POWER,      /* powered: the lamp's driver has power, or none */
};

/* As in the settings, but any value may be given: what is out of range is DENIED. */
struct illuminator_configure {
	uint32_t mode;
	uint32_t brightness_ppm;
	uint32_t strobe_period_us;
	uint32_t duty_ppm;
};

/*
 * While on, the lamp shows this brightness, steady, instead of the settings, which stay. Every
 * command ends it, and so do a thermal shutdown and the loss of power.
 */
struct illuminator_test {
	bool on;
	uint32_t brightness_ppm; /* 0…PPM_ONE, else DENIED */
};

struct illuminator_event {
	enum illuminator_event_kind kind;
	union {
		bool on_off;
		struct illuminator_configure configure;
		uint32_t brightness_ppm;
		struct thermal_report thermal;
		struct illuminator_config config;
		struct illuminator_settings restore;
		enum illuminator_fallback fallback;
		bool powered;
		struct illuminator_test test;
	};
};

/*
 * DENIED: a value out of range. FAILED: valid, but not now (on, or a test, during thermal shutdown
 * or without power, repeated or not). Neither changed anything.
 */
enum illuminator_result {
	ILLUMINATOR_ACCEPTED,
	ILLUMINATOR_DENIED,
	ILLUMINATOR_FAILED,
};

enum illuminator_notice_kind {
	ILLUMINATOR_NOTICE_THROTTLING_BEGINS,
	ILLUMINATOR_NOTICE_THROTTLING_ENDS,
	ILLUMINATOR_NOTICE_SHUTDOWN,
	ILLUMINATOR_NOTICE_RECOVERED,
	ILLUMINATOR_NOTICE_SENSOR_FAILED,
	ILLUMINATOR_NOTICE_SENSOR_OK,
};

/* What differs after a step, to be read from the illuminator itself. */
struct illuminator_outbox {
	bool light;    /* plan: to be carried out */
	bool settings; /* settings */
	bool status;   /* settings, flags or limits (not: temperature alone) */
	/* Bit per kind, to tell people in this order; the teller limits the rate. The fault of
	 * SENSOR_FAILED is the report's.
	 */
	uint8_t notices;
};

struct illuminator_stats {
	uint32_t accepted;
	uint32_t denied;
	uint32_t failed;
};

/* Readable by the owner; only the functions below write. */
struct illuminator {
	struct illuminator_settings settings;
	struct illuminator_config config;
	struct thermal_report thermal;
	struct light_plan plan;
	struct illuminator_test test;
	bool unpowered; /* the lamp is off, and stays so when power comes back */
	struct illuminator_stats stats;
	uint32_t revision;  /* advances with each change of settings, and with nothing else */
	int64_t changed_us; /* when it last advanced; 0: never */
};

/*
 * Off, internal, full brightness, no strobe, duty PPM_ONE; thermal: normal, sensor waiting. The
 * plan is dark. config asserted.
 */
void illuminator_init(struct illuminator *self, const struct illuminator_config *config);

/*
 * The one transition function. now_us 0…TIME_MAX_US. *out is overwritten, also when it stays empty.
 * CONFIG, THERMAL, FALLBACK and POWER are always ACCEPTED. RESTORE is checked as a command would be
 * (with enable during thermal shutdown FAILED).
 */
enum illuminator_result illuminator_step(struct illuminator *self, int64_t now_us,
                                         const struct illuminator_event *event,
                                         struct illuminator_outbox *out);

/*
 * What would become of all of these, one after the other: the first that is not ACCEPTED. Commands
 * only: what else an event changes besides the settings is not looked at.
 */
enum illuminator_result illuminator_try(const struct illuminator *self,
                                        const struct illuminator_event *events, size_t count);

/* ILLUMINATOR_ERROR_FLAGS now: THERMAL_FLAG_… */
uint32_t illuminator_error_flags(const struct illuminator *self);

/*
 * Linear light of a brightness, 0…PPM_ONE both. Monotone; exact at 0 and PPM_ONE; rounded half up.
 * CIE 15:2004 8.2.1, Y of L*. Any context.
 */
uint32_t illuminator_curve_ppm(enum illuminator_curve curve, uint32_t brightness_ppm);

/* Lit time of a period: rounded half up, at least 1 when duty_ppm > 0. Ranges as in the settings.
 */
uint32_t illuminator_on_us(uint32_t period_us, uint32_t duty_ppm);

/* What a strobe of this period may be: the nearest that the config allows. 0, none, stays. */
uint32_t illuminator_nearest_period_us(const struct illuminator_config *config, uint32_t period_us);

/* For people, constant and never NULL: "Throttling begins", … ; at most 40 bytes. */
const char *illuminator_notice_text(enum illuminator_notice_kind kind);

#endif
