/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device model, by Zephyr's names.
 *
 * A driver defines its devices with DEVICE_DT_INST_DEFINE() or DEVICE_DEFINE(); their init
 * functions run as <zephyr/init.h> says and return 0 or -errno. A device whose init function failed
 * is not ready.
 *
 * DEVICE_DT_GET(node_id) of a node that no driver defines a device for is a link error.
 */
#ifndef ZEPHYR_DEVICE_H_
#define ZEPHYR_DEVICE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/devicetree.h>
#include <zephyr/init.h>

struct pm_device;

struct device_state {
	struct pm_device *pm;
	uint8_t init_res; /* errno of the init function, at most 255 */
	bool initialized;
};

struct device {
	const char *name;
	const void *config;
	const void *api;
	struct device_state *state;
	void *data;
};

#define DEVICE_NAME_GET(dev_id)     NATIVE_DT_CAT(__device_, dev_id)
#define DEVICE_GET(dev_id)          (&DEVICE_NAME_GET(dev_id))
#define DEVICE_DECLARE(dev_id)      extern const struct device DEVICE_NAME_GET(dev_id)
#define DEVICE_DT_DEV_ID(node_id)   NATIVE_DT_CAT(dts_ord_, DT_DEP_ORD(node_id))
#define DEVICE_DT_NAME_GET(node_id) DEVICE_NAME_GET(DEVICE_DT_DEV_ID(node_id))
#define DEVICE_DT_NAME(node_id)     DT_NODE_FULL_NAME(node_id)
#define DEVICE_DT_GET(node_id)      (&DEVICE_DT_NAME_GET(node_id))
#define DEVICE_DT_INST_GET(inst)    DEVICE_DT_GET(DT_DRV_INST(inst))
#define DEVICE_DT_DECLARE(node_id)  extern const struct device DEVICE_DT_NAME_GET(node_id);
#define DEVICE_DT_GET_OR_NULL(node_id)                                                             \
	NATIVE_DT_IF(NATIVE_DT_CAT(node_id, _STATUS_okay), (DEVICE_DT_GET(node_id)), (NULL))
/* the first enabled device of that compatible; NULL when there is none */
#define DEVICE_DT_GET_ANY(compat)                                                                  \
	NATIVE_DT_IF(NATIVE_DT_CAT3(DT_COMPAT_, compat, _HAS_OKAY),                                \
	             (DEVICE_DT_GET(DT_INST(0, compat))), (NULL))

/*
 * The last arguments are those of DEVICE_DEFINE(): init function, power management, data, config,
 * level, priority, API. Nothing here makes a struct pm_device, so that pm can only be NULL.
 */
#define DEVICE_DEFINE(dev_id, ...) NATIVE_DEVICE_DEFINE(dev_id, __VA_ARGS__)
#define DEVICE_DT_DEFINE(node_id, ...)                                                             \
	DEVICE_DEFINE(DEVICE_DT_DEV_ID(node_id), DEVICE_DT_NAME(node_id), __VA_ARGS__)
#define DEVICE_DT_INST_DEFINE(inst, ...) DEVICE_DT_DEFINE(DT_DRV_INST(inst), __VA_ARGS__)

#define NATIVE_DEVICE_DEFINE(dev_id, dev_name, init, pm_ptr, data_ptr, config_ptr, lvl, prio_no,   \
                             api_ptr)                                                              \
	static struct device_state device_state_##dev_id = {.pm = (pm_ptr)};                       \
	const STRUCT_SECTION_ITERABLE(device, DEVICE_NAME_GET(dev_id)) = {                         \
		.name = (dev_name),                                                                \
		.config = (config_ptr),                                                            \
		.api = (api_ptr),                                                                  \
		.state = &device_state_##dev_id,                                                   \
		.data = (data_ptr),                                                                \
	};                                                                                         \
	static const STRUCT_SECTION_ITERABLE(init_entry, init_entry_dev_##dev_id) = {              \
		.init_fn = {.dev = (init)},                                                        \
		.dev = &DEVICE_NAME_GET(dev_id),                                                   \
		.level = INIT_LEVEL_OF(lvl),                                                       \
		.priority = (prio_no),                                                             \
	}

/* Any context, also before the device's level has run (then false). dev may be NULL: false. */
bool device_is_ready(const struct device *dev);

/* The ready device of that name (its node's name in the devicetree), or NULL. Any context. */
const struct device *device_get_binding(const char *name);

/* Every enabled node's device; its driver defines it. */
NATIVE_DT_FOREACH_OKAY_NODE(DEVICE_DT_DECLARE)

#endif
