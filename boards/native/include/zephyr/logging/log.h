/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Logging: the subset of Zephyr's API that the native port has.
 *
 *	LOG_MODULE_REGISTER(thermal, CONFIG_THERMAL_LOG_LEVEL);
 *	LOG_WRN("throttling: %d mdegC", temp_mdegc);
 *
 *	[00:00:01.234,567] <wrn> thermal: throttling: 61000 mdegC
 *
 * A source file that logs has one LOG_MODULE_REGISTER, or, in the other files of the same module,
 * LOG_MODULE_DECLARE; both take the name, and the level if it is not CONFIG_LOG_DEFAULT_LEVEL.
 * Macros may be used in any context, interrupts included. The text is rendered at the call, so that
 *a string argument need not outlive it, and waits in a ring for the log thread. A full ring drops
 *the message and counts it. A text longer than LOG_TEXT_MAX is cut and ends in "...".
 */
#ifndef ZEPHYR_LOGGING_LOG_H
#define ZEPHYR_LOGGING_LOG_H

#include <stddef.h>
#include <stdint.h>

#include <zephyr/toolchain.h>

#define LOG_LEVEL_NONE 0U
#define LOG_LEVEL_ERR  1U
#define LOG_LEVEL_WRN  2U
#define LOG_LEVEL_INF  3U
#define LOG_LEVEL_DBG  4U

/* Bytes of a text, and of a hex dump's data, that are kept. */
#define LOG_TEXT_MAX 240
#define LOG_DATA_MAX 256

struct log_source {
	const char *name;
};

/* level 1…4. Any context. */
void log_write(uint8_t level, const struct log_source *source, const char *fmt, ...)
	__attribute__((format(printf, 3, 4)));
void log_write_hexdump(uint8_t level, const struct log_source *source, const void *data,
                       size_t length, const char *text);

#ifdef CONFIG_LOG
#define LOG_SOURCE_LEVEL(name, level, ...)                                                         \
	((level) > CONFIG_LOG_OVERRIDE_LEVEL ? (level) : CONFIG_LOG_OVERRIDE_LEVEL)
#define LOG_IS_ON(_level) ((_level) <= log_source_level && (_level) <= CONFIG_LOG_MAX_LEVEL)
#define LOG_ARGS(...)     __VA_ARGS__, CONFIG_LOG_DEFAULT_LEVEL, 0
#else
#define LOG_SOURCE_LEVEL(name, level, ...) LOG_LEVEL_NONE
#define LOG_IS_ON(_level)                  ((_level) <= log_source_level)
#define LOG_ARGS(...)                      __VA_ARGS__, LOG_LEVEL_NONE, 0
#endif

#define LOG_SOURCE_NAME(name, ...)   log_source_##name
#define LOG_SOURCE_STRING(name, ...) #name
/* One more level, so that the arguments are expanded first. */
#define LOG_APPLY(macro, ...)        macro(__VA_ARGS__)

#define LOG_MODULE_REGISTER(...)                                                                   \
	const struct log_source LOG_APPLY(LOG_SOURCE_NAME, __VA_ARGS__, 0) = {                     \
		.name = LOG_APPLY(LOG_SOURCE_STRING, __VA_ARGS__, 0)};                             \
	LOG_MODULE_DECLARE(__VA_ARGS__)

#define LOG_MODULE_DECLARE(...)                                                                    \
	extern const struct log_source LOG_APPLY(LOG_SOURCE_NAME, __VA_ARGS__, 0);                 \
	static const struct log_source *const log_source_current __attribute__((unused)) =         \
		&LOG_APPLY(LOG_SOURCE_NAME, __VA_ARGS__, 0);                                       \
	static const uint32_t log_source_level __attribute__((unused)) =                           \
		LOG_APPLY(LOG_SOURCE_LEVEL, LOG_ARGS(__VA_ARGS__))

#define LOG_WRITE(_level, ...)                                                                     \
	do {                                                                                       \
		if (LOG_IS_ON(_level)) {                                                           \
			log_write((uint8_t)(_level), log_source_current, __VA_ARGS__);             \
		}                                                                                  \
	} while (0)

#define LOG_WRITE_HEXDUMP(_level, _data, _length, _str)                                            \
	do {                                                                                       \
		if (LOG_IS_ON(_level)) {                                                           \
			log_write_hexdump((uint8_t)(_level), log_source_current, _data, _length,   \
			                  _str);                                                   \
		}                                                                                  \
	} while (0)

#define LOG_ERR(...) LOG_WRITE(LOG_LEVEL_ERR, __VA_ARGS__)
#define LOG_WRN(...) LOG_WRITE(LOG_LEVEL_WRN, __VA_ARGS__)
#define LOG_INF(...) LOG_WRITE(LOG_LEVEL_INF, __VA_ARGS__)
#ifdef CONFIG_LOG_FUNC_NAME_PREFIX_DBG
#define LOG_DBG(fmt, ...) LOG_WRITE(LOG_LEVEL_DBG, "%s: " fmt, __func__, ##__VA_ARGS__)
#else
#define LOG_DBG(...) LOG_WRITE(LOG_LEVEL_DBG, __VA_ARGS__)
#endif

/* _str: one line above the data. */
#define LOG_HEXDUMP_ERR(_data, _length, _str) LOG_WRITE_HEXDUMP(LOG_LEVEL_ERR, _data, _length, _str)
#define LOG_HEXDUMP_WRN(_data, _length, _str) LOG_WRITE_HEXDUMP(LOG_LEVEL_WRN, _data, _length, _str)
#define LOG_HEXDUMP_INF(_data, _length, _str) LOG_WRITE_HEXDUMP(LOG_LEVEL_INF, _data, _length, _str)
#define LOG_HEXDUMP_DBG(_data, _length, _str) LOG_WRITE_HEXDUMP(LOG_LEVEL_DBG, _data, _length, _str)

#endif
