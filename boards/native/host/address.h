/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOST:PORT, with HOST a name, an IPv4 address, or an IPv6 address in brackets; PORT 0…65535.
 * Numeric hosts are resolved at once. A name is looked up by a child process, so that a dead name
 * server never stops the light.
 */
#ifndef NATIVE_HOST_ADDRESS_H_
#define NATIVE_HOST_ADDRESS_H_

#include <stdbool.h>
#include <stddef.h>
#include <sys/socket.h>

#include "host/error.h"

struct address {
	struct sockaddr_storage to;
	socklen_t length; /* 0: not known yet */
	char host[128];
	char port[8];
	int lookup_fd; /* result of a look-up under way, 0: none */
	int lookup_pid;
};

/* 0, or -1 with a reason. */
int address_parse(struct address *address, const char *text, struct host_error *error);

/* True when it is known. Else starts a look-up or looks at its result; failed: *error is not 0
 * (errno). */
bool address_resolve(struct address *address, int *error);

/* Ends a look-up under way. */
void address_stop(struct address *address);

/* "127.0.0.1:14550", "[::1]:14550". */
void address_print(const struct sockaddr_storage *address, char *text, size_t size);

/* The address a socket is bound to, printed. */
void address_print_bound(int fd, char *text, size_t size);

bool address_equal(const struct sockaddr_storage *a, const struct sockaddr_storage *b);

/* The same but for the port. */
bool address_same_host(const struct sockaddr_storage *a, const struct sockaddr_storage *b);

#endif
