/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What survives a power cut: parameters, the signing key and, if LGT_RESTORE says so, the last
 * commanded settings.
 * Writing happens in a low-priority thread, after the answer; each value is written whole or not at
 * all (Zephyr settings). Writes of one value that come faster than the store takes them are one.
 */
#ifndef PHAROS_THREADS_STORAGE_H
#define PHAROS_THREADS_STORAGE_H

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/kernel.h>

#include "core/illuminator.h"
#include "core/params.h"
#include "proto/mavlink/signing.h"

/* A write that takes longer counts as failed, -ETIMEDOUT; a page's erasing is in it. */
#define STORAGE_WRITE_MS 10000

struct storage_stats {
	uint32_t writes;
	uint32_t failures;
	uint32_t refused; /* stored values that do not fit the table (any more); defaults apply */
	int32_t last_error;
};

/*
 * Before the threads start. Puts the stored parameters over those in *params; *light and
 * *has_light: the last commanded settings. 0, or -errno of the store: the defaults stay.
 */
int storage_load(struct params *params, struct illuminator_settings *light, bool *has_light);

/* Write the parameters of the mask, as they are now. Command thread. */
void storage_save_params(const struct params *params, const struct param_set *changed);

/* Write the settings, once they have settled (core/settle.h). Command thread. */
void storage_save_light(const struct illuminator_settings *light);

#ifdef CONFIG_PHAROS_IMC
/* The power channels that are on after a start, as a mask, or -1: never saved. After
 * storage_load().
 */
int storage_load_power(void);

/* Write them. Command thread. */
void storage_save_power(uint8_t mask);
#endif

#ifdef CONFIG_PHAROS_SIGNING
/* The signing key and timestamp of the last run; all zero: none. After storage_load(). */
void storage_load_signing(struct mavlink_signing_record *record);

/* Write them: one value, so never one without the other. Command thread. */
void storage_save_signing(const struct mavlink_signing_record *record);
#endif

/* Any thread. */
struct storage_stats storage_stats_get(void);

/* Runs the work in storage's thread, between two writes: for what is slow with flash as well. It
 * may be submitted again at once. After storage_start(); any context. */
void storage_submit(struct k_work *work);

/* Begins to write. Once, after storage_load(). */
void storage_start(void);

#endif
