/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What survives a power cut: parameters, the signing key, the power channels and, if LGT_RESTORE
 * says so, the last commanded settings. The rules are core/store's: what one call here gives is
 * stored together, and in the order of the calls. It is written in storage's thread, after the
 * answer.
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
/* What waits for longer behind the update's flash has failed: an H7's slot takes 24 s to erase. */
#define STORAGE_WAIT_MS  60000

struct storage_stats {
	uint32_t writes;
	uint32_t failures;
	uint32_t refused; /* stored values and records that do not fit or cannot be read */
	int32_t last_error;
};

/*
 * Before the threads start. *params: the stored parameters, else the defaults; *light and
 * *has_light: the last commanded settings. 0, or -errno of the store: what could be read applies.
 */
int storage_load(struct params *params, struct illuminator_settings *light, bool *has_light);

/* The parameters of the set were accepted together, as they are now. Command thread. */
void storage_save_params(const struct params *params, const struct param_set *changed);

/* The settings were accepted; written once they have settled. Command thread. */
void storage_save_light(const struct illuminator_settings *light);

#ifdef CONFIG_PHAROS_IMC
/* The power channels that are on after a start, as a mask; fallback: nobody has saved any. After
 * storage_load().
 */
uint8_t storage_load_power(uint8_t fallback);

/* They were accepted. The mask that is stored already costs nothing. Command thread. */
void storage_save_power(uint8_t mask);
#endif

#ifdef CONFIG_PHAROS_SIGNING
/* The signing key and timestamp of the last run; all zero: none. After storage_load(). */
void storage_load_signing(struct mavlink_signing_record *signing);

/* They were accepted. Command thread. */
void storage_save_signing(const struct mavlink_signing_record *signing);
#endif

/* Any thread. */
struct storage_stats storage_stats_get(void);

/* Runs the work in storage's thread, between two writes: for what is slow with flash as well. It
 * may be submitted again at once. After storage_start(); any context.
 */
void storage_submit(struct k_work *work);

/* Begins to write. Once, after storage_load(). */
void storage_start(void);

#endif
