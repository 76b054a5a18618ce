/* SPDX-License-Identifier: Apache-2.0 */
#include "pwm_channel_host.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/claim.h"

enum {
	/* udev gives a new channel's files to its group a little after they are there */
	ACCESS_TRIES = 50,
	ACCESS_TRY_US = 20000,
};

static const struct sysfs_class chips = {"class/pwm", "pwmchip", NULL, "PWM chip"};

static int write_number(int fd, uint32_t number)
{
	char text[16];
	const int length = snprintf(text, sizeof(text), "%u\n", number);

	return pwrite(fd, text, (size_t)length, 0) == length ? 0 : -errno;
}

static int set_number(const struct pwm_channel *self, const char *attribute, uint32_t number)
{
	char text[16];

	(void)snprintf(text, sizeof(text), "%u\n", number);
	return sysfs_write(self->path, attribute, text);
}

static int open_file(const struct pwm_channel *self, const char *attribute, int *fd)
{
	char path[SYSFS_PATH_SIZE + 16];

	(void)snprintf(path, sizeof(path), "%s/%s", self->path, attribute);
	for (int i = 0; i < ACCESS_TRIES; i++) {
		*fd = open(path, O_RDWR | O_CLOEXEC);
		if (*fd >= 0 || errno != EACCES) {
			break;
		}
		usleep(ACCESS_TRY_US);
	}
	return *fd >= 0 ? 0 : -errno;
}

int pwm_channel_find(struct pwm_channel *self, const struct pwm_place *place,
                     struct host_error *error)
{
	double count;

	/* while it is nowhere, its number may be another chip's */
	self->path[0] = '\0';
	if (sysfs_find(&chips, place->chip, self->chip, error) != 0) {
		return -1;
	}
	if (sysfs_read_number(self->chip, "npwm", &count) == 0 && place->channel >= count) {
		return host_error_set(error, "%s has channels 0 to %.0f", place->chip, count - 1);
	}
	self->channel = place->channel;
	if ((size_t)snprintf(self->path, sizeof(self->path), "%s/pwm%u", self->chip,
	                     place->channel) >= sizeof(self->path)) {
		self->path[0] = '\0';
		return host_error_set(error, "%s: too long a path", self->chip);
	}
	return 0;
}

static void close_fd(int *fd)
{
	if (*fd >= 0) {
		close(*fd);
		*fd = -1;
	}
}

/* One that we have we keep: our guard has it as well. A chip that was plugged in anew is another.
 */
static int claim(struct pwm_channel *self, bool *is_ours, struct host_error *error)
{
	struct stat folder;

	if (stat(self->chip, &folder) != 0) {
		return host_error_set(error, "%s: %s", self->chip, strerror(errno));
	}
	if (self->claim_fd >= 0 && self->claim_device == folder.st_dev &&
	    self->claim_folder == folder.st_ino) {
		return 0;
	}
	close_fd(&self->claim_fd);
	self->claim_fd = claim_name(self->path);
	if (self->claim_fd >= 0) {
		self->claim_device = folder.st_dev;
		self->claim_folder = folder.st_ino;
		return 0;
	}
	*is_ours = errno == EADDRINUSE;
	return host_error_set(error, "%s: %s", self->path,
	                      *is_ours ? "another light has it" : strerror(errno));
}

/* One that is there already is somebody else's to unexport: a rule of udev's, say. */
static int export(struct pwm_channel *self, struct host_error *error)
{
	char text[16];
	int rc;

	if (sysfs_has(self->path, "duty_cycle")) {
		return 0;
	}
	(void)snprintf(text, sizeof(text), "%u\n", self->channel);
	rc = sysfs_write(self->chip, "export", text);
	if (rc != 0) {
		return host_error_set(error, "%s: channel %u: %s", self->chip, self->channel,
		                      rc == -EBUSY ? "in use by the kernel" : strerror(-rc));
	}
	self->is_exported = true;
	return 0;
}

/* Without a polarity, a chip has the normal one. */
static int set_polarity(struct pwm_channel *self, const char *polarity)
{
	char line[SYSFS_LINE_SIZE];
	int rc = sysfs_read(self->path, "polarity", line);

	if (rc == -ENOENT && strcmp(polarity, "normal") == 0) {
		return 0;
	}
	if (rc == 0 && strcmp(line, polarity) != 0) {
		/* it can only be set while the output is off */
		(void)write_number(self->enable_fd, 0);
		rc = sysfs_write(self->path, "polarity", polarity);
	}
	return rc;
}

/* The pulse first: the period cannot be below it, and nobody promises the level of an output that
 * is off. */
static int configure(struct pwm_channel *self, const struct pwm_place *place,
                     struct host_error *error)
{
	const char *polarity = place->is_inverted ? "inversed" : "normal";
	int rc;

	(void)write_number(self->duty_fd, 0);
	rc = set_number(self, "period", place->period_ns);
	if (rc != 0) {
		return host_error_set(
			error, "%s: period=%gus: %s; some chips have one period for all channels",
			self->path, place->period_ns / 1e3, strerror(-rc));
	}
	rc = set_polarity(self, polarity);
	if (rc != 0) {
		return host_error_set(error, "%s: polarity %s: %s", self->path, polarity,
		                      strerror(-rc));
	}
	self->is_inverted = place->is_inverted;
	rc = write_number(self->duty_fd, 0);
	if (rc == 0) {
		rc = write_number(self->enable_fd, 1);
	}
	return rc == 0 ? 0 : host_error_set(error, "%s: %s", self->path, strerror(-rc));
}

void pwm_channel_init(struct pwm_channel *self)
{
	*self = (struct pwm_channel){.claim_fd = -1, .duty_fd = -1, .enable_fd = -1};
}

int pwm_channel_open(struct pwm_channel *self, const struct pwm_place *place, bool is_exported,
                     bool *is_ours, struct host_error *error)
{
	int rc;

	close_fd(&self->duty_fd);
	close_fd(&self->enable_fd);
	self->is_exported = is_exported;
	self->is_inverted = false;
	*is_ours = false;
	rc = pwm_channel_find(self, place, error);
	if (rc == 0) {
		rc = claim(self, is_ours, error);
	}
	if (rc == 0) {
		rc = export(self, error);
	}
	if (rc == 0) {
		rc = open_file(self, "duty_cycle", &self->duty_fd);
		if (rc == 0) {
			rc = open_file(self, "enable", &self->enable_fd);
		}
		if (rc != 0) {
			rc = host_error_set(error, "%s: %s", self->path, strerror(-rc));
		}
	}
	if (rc == 0) {
		rc = configure(self, place, error);
	}
	if (rc != 0) {
		if (self->claim_fd >= 0) {
			pwm_channel_end(self);
		}
		close_fd(&self->duty_fd);
		close_fd(&self->enable_fd);
	}
	return rc;
}

int pwm_channel_write(const struct pwm_channel *self, uint32_t pulse_ns)
{
	return write_number(self->duty_fd, pulse_ns);
}

int pwm_channel_check(const struct pwm_channel *self)
{
	char byte;

	return pread(self->duty_fd, &byte, 1, 0) == 1 ? 0 : -errno;
}

void pwm_channel_end(const struct pwm_channel *self)
{
	char text[16];

	if (self->duty_fd >= 0) {
		(void)write_number(self->duty_fd, 0);
	}
	if (self->is_inverted) {
		return;
	}
	if (self->enable_fd >= 0) {
		(void)write_number(self->enable_fd, 0);
	}
	if (self->is_exported && self->path[0] != '\0') {
		(void)snprintf(text, sizeof(text), "%u\n", self->channel);
		(void)sysfs_write(self->chip, "unexport", text);
	}
}

void pwm_channel_close(struct pwm_channel *self)
{
	close_fd(&self->duty_fd);
	close_fd(&self->enable_fd);
	close_fd(&self->claim_fd);
}
