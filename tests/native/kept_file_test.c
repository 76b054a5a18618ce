/* SPDX-License-Identifier: Apache-2.0 */
/* A kept file by itself, in a folder of its own. The first check that fails ends the program. */
#include <stdio.h>
#include <stdlib.h>

#undef main

#include "host/kept_file.c"

static struct host_error reason;

static void check(bool holds, const char *what, int line)
{
	if (!holds) {
		printf("kept_file_test.c:%d: %s (%s)\n", line, what, reason.text);
		exit(1);
	}
}

#define CHECK(condition) check(condition, #condition, __LINE__)

static void put(const char *path, const char *text, mode_t mode)
{
	const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, mode);

	CHECK(fd >= 0 && fchmod(fd, mode) == 0);
	CHECK(write(fd, text, strlen(text)) == (ssize_t)strlen(text));
	close(fd);
}

static bool has(const char *path, const char *text)
{
	char bytes[64] = "";
	const int fd = open(path, O_RDONLY);
	const ssize_t n = read(fd, bytes, sizeof(bytes) - 1);

	close(fd);
	return n == (ssize_t)strlen(text) && memcmp(bytes, text, (size_t)n) == 0;
}

static mode_t mode_of(const char *path)
{
	struct stat status;

	CHECK(lstat(path, &status) == 0);
	return status.st_mode & 07777;
}

static struct kept_file open_file(const char *path)
{
	struct kept_file file;

	CHECK(kept_file_open(&file, path, -1, &reason) == 0);
	return file;
}

static void refused(const char *path, const char *why)
{
	struct kept_file file;

	CHECK(kept_file_open(&file, path, -1, &reason) != 0);
	CHECK(strstr(reason.text, why) != NULL);
}

static void test_content(void)
{
	struct kept_file file = open_file("content");
	char bytes[8] = "";

	CHECK(kept_file_length(&file) == 0);
	CHECK(kept_file_append(&file, "abc", 3) == 0);
	CHECK(kept_file_append(&file, "def", 3) == 0);
	CHECK(kept_file_read(&file, 2, bytes, 3) == 0 && strcmp(bytes, "cde") == 0);
	CHECK(kept_file_read(&file, 4, bytes, 3) == -EIO);
	CHECK(kept_file_replace(&file, "xy", 2, false) == 0);
	CHECK(has("content", "xy") && kept_file_length(&file) == 2);
	CHECK(kept_file_append(&file, "z", 1) == 0);
	CHECK(has("content", "xyz"));
	CHECK(kept_file_replace(&file, "never", 5, true) == -EIO);
	CHECK(has("content", "xyz"));
	CHECK(kept_file_replace(&file, "new", 3, false) == 0);
	CHECK(has("content", "new"));
	CHECK(unlink("content") == 0);
	CHECK(kept_file_append(&file, "lost", 4) == -ENOENT);
	kept_file_close(&file);
}

static void test_nobody_else_reads_it(void)
{
	struct kept_file file;

	umask(0);
	put("old", "key", 0644);
	file = open_file("old");
	CHECK(mode_of("old") == 0600);
	CHECK(kept_file_replace(&file, "key2", 4, false) == 0);
	CHECK(mode_of("old") == 0600);
	kept_file_close(&file);
	file = open_file("fresh");
	CHECK(mode_of("fresh") == 0600);
	kept_file_close(&file);
}

static void test_no_link_is_followed(void)
{
	struct kept_file file;

	put("victim", "mine", 0644);
	CHECK(symlink("victim", "link") == 0 && symlink("victim", "file.new") == 0);
	refused("link", "symbolic link");
	file = open_file("file");
	CHECK(kept_file_replace(&file, "key", 3, false) == 0);
	CHECK(has("victim", "mine") && mode_of("victim") == 0644);
	CHECK(has("file", "key"));
	kept_file_close(&file);
	/* what a cut has left is no hindrance, nor kept */
	put("file.new", "half", 0666);
	file = open_file("file");
	CHECK(kept_file_replace(&file, "key3", 4, false) == 0);
	CHECK(has("file", "key3") && mode_of("file") == 0600);
	kept_file_close(&file);
}

static void test_one_at_a_time(void)
{
	struct kept_file file = open_file("locked");

	refused("locked", "another light has it");
	CHECK(kept_file_replace(&file, "a", 1, false) == 0);
	refused("locked", "another light has it");
	kept_file_close(&file);
	file = open_file("locked");
	kept_file_close(&file);
}

static void test_after_a_reset_it_is_the_file_of_that_name(void)
{
	struct kept_file file = open_file("kept");
	const int fd = file.fd;

	CHECK(kept_file_open(&file, "kept", fd, &reason) == 0 && file.fd == fd);
	put("other", "restored", 0600);
	CHECK(rename("other", "kept") == 0);
	CHECK(kept_file_open(&file, "kept", fd, &reason) == 0);
	CHECK(kept_file_length(&file) == 8);
	kept_file_close(&file);
}

static void test_what_is_no_file(void)
{
	refused("nowhere/file", "No such file or directory");
	refused(".", "not a regular file");
	CHECK(mkfifo("fifo", 0600) == 0);
	refused("fifo", "not a regular file");
}

int main(void)
{
	char folder[] = "/tmp/kept_file_XXXXXX";

	CHECK(mkdtemp(folder) != NULL && chdir(folder) == 0);
	test_content();
	test_nobody_else_reads_it();
	test_no_link_is_followed();
	test_one_at_a_time();
	test_after_a_reset_it_is_the_file_of_that_name();
	test_what_is_no_file();
	printf("6 tests passed\n");
	fflush(stdout);
	return execlp("rm", "rm", "-r", folder, NULL);
}
