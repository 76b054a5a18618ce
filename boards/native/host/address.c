/* SPDX-License-Identifier: Apache-2.0 */
#include "host/address.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/options.h"

static bool look_up(struct address *address, int flags)
{
	const struct addrinfo hints = {
		.ai_family = AF_UNSPEC, .ai_socktype = SOCK_DGRAM, .ai_flags = flags};
	struct addrinfo *found;
	struct addrinfo *at;

	if (getaddrinfo(address->host, address->port, &hints, &found) != 0) {
		return false;
	}
	/* A name may be both: what drones and their tools listen on is IPv4. */
	for (at = found; at->ai_next != NULL && at->ai_family != AF_INET;) {
		at = at->ai_next;
	}
	at = at->ai_family == AF_INET ? at : found;
	memcpy(&address->to, at->ai_addr, at->ai_addrlen);
	address->length = at->ai_addrlen;
	freeaddrinfo(found);
	return true;
}

int address_parse(struct address *address, const char *text, struct host_error *error)
{
	const char *colon = strrchr(text, ':');
	size_t host = colon != NULL ? (size_t)(colon - text) : 0;
	struct host_error reason;
	uint64_t port;

	if (colon == NULL || host == 0) {
		return host_error_set(error, "\"%.60s\" is not HOST:PORT, such as 127.0.0.1:14550",
		                      text);
	}
	if (parse_number(colon + 1, 0, 65535, &port, &reason) != 0) {
		return host_error_set(error, "port: %.200s", reason.text);
	}
	if (text[0] == '[' && text[host - 1] == ']') {
		text++;
		host -= 2;
	} else if (memchr(text, ':', host) != NULL) {
		return host_error_set(
			error, "\"%.60s\": an IPv6 address goes in brackets: [::1]:14550", text);
	}
	if (host == 0 || host >= sizeof(address->host)) {
		return host_error_set(error, "\"%.60s\": no usable host name", text);
	}
	*address = (struct address){.lookup_fd = 0};
	memcpy(address->host, text, host);
	snprintf(address->port, sizeof(address->port), "%u", (unsigned int)port);
	/* RFC 6761: never asked of a resolver, which has no answer where there is no /etc/hosts. */
	if (strcmp(address->host, "localhost") == 0) {
		strcpy(address->host, "127.0.0.1");
	}
	/* A name is left to a child. */
	(void)look_up(address, AI_NUMERICHOST | AI_NUMERICSERV);
	return 0;
}

static void start_look_up(struct address *address)
{
	int ends[2];
	pid_t pid;

	if (pipe2(ends, O_CLOEXEC) != 0) {
		return;
	}
	pid = fork();
	if (pid == 0) {
		if (look_up(address, AI_NUMERICSERV) &&
		    write(ends[1], &address->to, address->length) < 0) {
			_exit(1);
		}
		_exit(0);
	}
	close(ends[1]);
	if (pid < 0) {
		close(ends[0]);
		return;
	}
	fcntl(ends[0], F_SETFL, O_NONBLOCK);
	address->lookup_fd = ends[0];
	address->lookup_pid = pid;
}

void address_stop(struct address *address)
{
	if (address->lookup_fd != 0) {
		kill(address->lookup_pid, SIGKILL);
		waitpid(address->lookup_pid, NULL, 0);
		close(address->lookup_fd);
		address->lookup_fd = 0;
	}
}

bool address_resolve(struct address *address, int *error)
{
	ssize_t n;

	*error = 0;
	if (address->length != 0) {
		return true;
	}
	if (address->lookup_fd == 0) {
		start_look_up(address);
		return false;
	}
	n = read(address->lookup_fd, &address->to, sizeof(address->to));
	if (n < 0 && errno == EAGAIN) {
		return false;
	}
	address_stop(address);
	if (n <= 0) {
		*error = EHOSTUNREACH;
		return false;
	}
	address->length = (socklen_t)n;
	return true;
}

void address_print(const struct sockaddr_storage *address, char *text, size_t size)
{
	char host[NI_MAXHOST] = "?";
	char port[NI_MAXSERV] = "?";
	const bool six = address->ss_family == AF_INET6;
	const socklen_t length =
		six ? sizeof(struct sockaddr_in6) : (socklen_t)sizeof(struct sockaddr_in);

	getnameinfo((const struct sockaddr *)address, length, host, sizeof(host), port,
	            sizeof(port), NI_NUMERICHOST | NI_NUMERICSERV);
	snprintf(text, size, "%s%s%s:%s", six ? "[" : "", host, six ? "]" : "", port);
}

void address_print_bound(int fd, char *text, size_t size)
{
	struct sockaddr_storage bound;
	socklen_t length = sizeof(bound);

	if (fd < 0 || getsockname(fd, (struct sockaddr *)&bound, &length) != 0) {
		snprintf(text, size, "-");
		return;
	}
	address_print(&bound, text, size);
}

bool address_same_host(const struct sockaddr_storage *a, const struct sockaddr_storage *b)
{
	struct sockaddr_storage alike = *b;

	if (a->ss_family != b->ss_family) {
		return false;
	}
	if (a->ss_family == AF_INET) {
		((struct sockaddr_in *)&alike)->sin_port =
			((const struct sockaddr_in *)a)->sin_port;
	} else {
		((struct sockaddr_in6 *)&alike)->sin6_port =
			((const struct sockaddr_in6 *)a)->sin6_port;
	}
	return address_equal(a, &alike);
}

bool address_equal(const struct sockaddr_storage *a, const struct sockaddr_storage *b)
{
	const struct sockaddr_in *a4 = (const struct sockaddr_in *)a;
	const struct sockaddr_in *b4 = (const struct sockaddr_in *)b;
	const struct sockaddr_in6 *a6 = (const struct sockaddr_in6 *)a;
	const struct sockaddr_in6 *b6 = (const struct sockaddr_in6 *)b;

	if (a->ss_family != b->ss_family) {
		return false;
	}
	if (a->ss_family == AF_INET) {
		return a4->sin_port == b4->sin_port && a4->sin_addr.s_addr == b4->sin_addr.s_addr;
	}
	return a6->sin6_port == b6->sin6_port && a6->sin6_scope_id == b6->sin6_scope_id &&
	       memcmp(&a6->sin6_addr, &b6->sin6_addr, sizeof(a6->sin6_addr)) == 0;
}
