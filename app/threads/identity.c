/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/identity.h"

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/sys/printk.h>

#include "threads/metadata.h"

#define DEVICE_ID_BYTES 12

static char serial_number[2 * DEVICE_ID_BYTES + 1];

static const struct mavlink_identity identity = {
	.vendor_name = CONFIG_PHAROS_VENDOR_NAME,
	.model_name = CONFIG_PHAROS_MODEL_NAME,
	.software_version = PHAROS_VERSION,
	.hardware_version = CONFIG_PHAROS_HARDWARE_VERSION,
	.serial_number = serial_number,
#ifdef CONFIG_PHAROS_FTP
	.files = &metadata_files,
#endif
	.version_code =
		PHAROS_VERSION_MAJOR << 24 | PHAROS_VERSION_MINOR << 16 | PHAROS_VERSION_PATCH << 8,
};

const struct mavlink_identity *identity_get(void)
{
	uint8_t id[DEVICE_ID_BYTES];
	const ssize_t length = hwinfo_get_device_id(id, sizeof(id));

	for (ssize_t i = 0; i < length; i++) {
		snprintk(&serial_number[2 * i], 3, "%02x", id[i]);
	}
	return &identity;
}

void identity_boot_text(char text[IDENTITY_BOOT_TEXT_MAX])
{
	char cause[RESET_CAUSE_TEXT_MAX];

	reset_cause_text(cause);
	snprintk(text, IDENTITY_BOOT_TEXT_MAX, "Pharos %s: %s", PHAROS_VERSION, cause);
}
