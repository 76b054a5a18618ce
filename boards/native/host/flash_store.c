/* SPDX-License-Identifier: Apache-2.0 */
#include "host/flash_store.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "devices/bridge.h"
#include "host/carry.h"
#include "host/claim.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/module.h"
#include "host/say.h"
#include "models/bootloader.h"

static struct flash flash = {.size = FLASH_STORE_SIZE};
static const char *path;
static int fd = -1;
static bool is_copy; /* memory is, of the file */

struct flash *flash_store(void)
{
	return &flash;
}

/* --- the file of a copy ------------------------------------------------------------------------
 */

struct range {
	uint32_t offset;
	uint32_t size;
	int rc;
};

static void write_range(void *arg)
{
	struct range *range = arg;

	for (uint32_t done = 0; done < range->size && range->rc == 0;) {
		const ssize_t n = pwrite(fd, flash.inverted + range->offset + done,
		                         range->size - done, (off_t)(range->offset + done));

		if (n > 0) {
			done += (uint32_t)n;
		} else if (n < 0 && errno != EINTR) {
			range->rc = -errno;
		}
	}
}

int flash_store_keep(uint32_t offset, uint32_t size)
{
	struct range range = {.offset = offset, .size = size};

	if (is_copy) {
		bridge_wait_for(write_range, &range);
	}
	return range.rc;
}

static bool read_copy(void)
{
	for (uint32_t done = 0; done < FLASH_STORE_SIZE;) {
		const ssize_t n =
			pread(fd, flash.inverted + done, FLASH_STORE_SIZE - done, (off_t)done);

		if (n <= 0 && errno != EINTR) {
			return false;
		}
		done += n > 0 ? (uint32_t)n : 0;
	}
	return true;
}

/* --- options and faults ----------------------------------------------------------------------- */

static int parse_path(const char *value, struct host_error *error)
{
	struct stat status;

	if (value[0] == '\0') {
		return host_error_set(error, "a file name is missing");
	}
	if (stat(value, &status) == 0 &&
	    (!S_ISREG(status.st_mode) ||
	     (status.st_size != 0 && status.st_size != FLASH_STORE_SIZE))) {
		return host_error_set(error,
		                      "%s is not a flash of %u bytes; give the path of one, or of "
		                      "one to make",
		                      value, FLASH_STORE_SIZE);
	}
	path = value;
	return 0;
}

static const struct host_option options[] = {
	{"flash", "FILE", "keep the image slots in this file, inverted (default: in memory)",
         parse_path},
	{0},
};

static enum control_result set_fault(struct control_call *call)
{
	const char *kind;
	int64_t byte;

	if (!control_string(call, "kind", &kind)) {
		return CONTROL_ERROR;
	}
	if (strcmp(kind, "none") == 0) {
		flash_power_up(&flash);
		return CONTROL_OK;
	}
	if (strcmp(kind, "torn") != 0) {
		return control_fail(call, "flash has no fault \"%.40s\"; there are none, torn",
		                    kind);
	}
	if (!control_integer(call, "byte", 0, INT64_MAX, &byte)) {
		return CONTROL_ERROR;
	}
	flash_tear(&flash, (uint64_t)byte);
	return CONTROL_OK;
}

static const struct control_fault faults[] = {
	{"flash",
         "kind torn with byte: writing fails after that many more bytes, until a reset; kind none",
         set_fault},
	{0},
};

/* --- start and reset -------------------------------------------------------------------------- */

static int open_store(void)
{
	size_t size = 0;
	const int *const carried = carry_get("flash", &size);

	if (carried != NULL && size == sizeof(*carried)) {
		return *carried;
	}
	if (path == NULL) {
		return memfd_create("flash", MFD_CLOEXEC);
	}
	return open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
}

static int fail(const char *reason)
{
	host_say("--flash: %s: %s", path == NULL ? "memory" : path, reason);
	return -1;
}

/* 0 or -errno. */
static int boot(void)
{
	struct range all = {.size = FLASH_STORE_SIZE};
	static const struct bootloader_slots slots = {
		.first = 0,
		.second = FLASH_SLOT_SIZE,
		.size = FLASH_SLOT_SIZE,
	};

	switch (bootloader_run(&flash, &slots)) {
	case BOOTLOADER_NOTHING:
		return 0;
	case BOOTLOADER_SWAPPED:
		host_say("bootloader: the new image starts, for a test");
		break;
	case BOOTLOADER_REVERTED:
		host_say("bootloader: the new image was not confirmed; the old one is back");
		break;
	case BOOTLOADER_REFUSED:
		host_say("bootloader: the new image is not whole and does not start");
		break;
	}
	if (is_copy) {
		write_range(&all);
	}
	return all.rc;
}

static int start(void)
{
	int error;

	fd = open_store();
	if (fd >= 0 && claim_file(fd) != 0) {
		return fail("another light has it");
	}
	if (fd < 0 || ftruncate(fd, FLASH_STORE_SIZE) != 0) {
		return fail(strerror(errno));
	}
	is_copy = path != NULL && !clock_is_virtual();
	flash.inverted =
		mmap(NULL, FLASH_STORE_SIZE, PROT_READ | PROT_WRITE,
	             is_copy ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED, is_copy ? -1 : fd, 0);
	if (flash.inverted == MAP_FAILED || (is_copy && !read_copy())) {
		return fail(strerror(errno));
	}
	(void)carry_register("flash torn", &flash.torn, sizeof(flash.torn));
	error = boot();
	return error == 0 ? 0 : fail(strerror(-error));
}

static void save(void)
{
	bridge_finish();
	carry_put("flash", &fd, sizeof(fd));
	carry_fd(fd);
}

static void stop(void)
{
	bridge_finish();
	if (fd >= 0) {
		close(fd);
	}
}

HOST_MODULE(flash_module) = {
	.name = "flash",
	.order = HOST_ORDER_BOARD,
	.options = options,
	.faults = faults,
	.start = start,
	.save = save,
	.stop = stop,
};
