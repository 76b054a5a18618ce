/* SPDX-License-Identifier: Apache-2.0 */
#include "host/control.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "host/buffer.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/named_socket.h"
#include "host/say.h"
#include "kernel/port.h"

enum {
	CLIENTS_MAX = 8,
	INPUT_MAX = 4 * CONTROL_LINE_MAX, /* read ahead of what has been run */
	OUTPUT_MAX = 16 << 20,            /* a client that asks and never reads is dropped */
	ID_MAX = 128,
	ACCEPT_AGAIN_MS = 1000, /* out of descriptors: rather than spin */
};

struct client {
	struct loop_source source;
	struct buffer in;
	struct buffer out;
	bool open;
	bool ended;    /* it writes no more */
	bool gone;     /* it reads no more either */
	bool skipping; /* the rest of a line that was too long */
};

/* What is carried of a client, followed by its two buffers. */
struct client_carried {
	int fd;
	uint32_t in_length;
	uint32_t out_length;
	bool ended;
	bool skipping;
};

static const char *path;
static struct loop_source listener;
static struct loop_timer listen_again;
static struct named_socket own;
static struct client clients[CLIENTS_MAX];
static unsigned int next_client; /* turns */
static bool maybe_lines;
static bool quitting;
static void (*on_gone)(void);

static struct {
	uint64_t requests;
	uint64_t errors;
	/* The request whose reply comes later. */
	bool pending;
	int pending_client; /* -1: it has gone */
	char pending_id[ID_MAX];
	bool is_deaf; /* no client can be taken, which was told */
} state;

/* --- output --------------------------------------------------------------------------------------
 */

static void update(struct client *client)
{
	uint32_t events = 0;

	if (!client->ended && buffer_length(&client->in) < INPUT_MAX) {
		events |= EPOLLIN;
	}
	if (buffer_length(&client->out) > 0) {
		events |= EPOLLOUT;
	}
	loop_want(&client->source, events);
}

void control_on_gone(void (*gone)(void))
{
	on_gone = gone;
}

/* Nobody waits for the pending request's reply any more. */
static void abandon(void)
{
	state.pending_client = -1;
	if (on_gone != NULL) {
		on_gone();
	}
}

static void set_gone(struct client *client)
{
	client->gone = true;
	client->ended = true;
	loop_remove(&client->source);
	buffer_consume(&client->out, buffer_length(&client->out));
	if (state.pending && state.pending_client == (int)(client - clients)) {
		abandon();
	}
}

static void drain(struct client *client)
{
	while (!client->gone && buffer_length(&client->out) > 0) {
		const ssize_t n = send(client->source.fd, buffer_bytes(&client->out),
		                       buffer_length(&client->out), MSG_NOSIGNAL | MSG_DONTWAIT);

		if (n > 0) {
			buffer_consume(&client->out, (size_t)n);
		} else if (errno == EAGAIN) {
			break;
		} else if (errno != EINTR) {
			set_gone(client);
		}
	}
	if (!client->gone) {
		update(client);
	}
}

static void send_line(struct client *client, json_t *reply)
{
	char *text = json_dumps(reply, JSON_COMPACT);

	if (text == NULL) {
		abort();
	}
	if (!client->gone) {
		if (!buffer_append(&client->out, text, strlen(text), OUTPUT_MAX) ||
		    !buffer_append(&client->out, "\n", 1, OUTPUT_MAX)) {
			set_gone(client);
		}
		drain(client);
	}
	free(text);
}

/* Takes body. error NULL: it went well. id may be NULL. */
static void answer(struct client *client, json_t *body, json_t *id, const char *error)
{
	json_t *reply = json_object();

	json_object_set_new(reply, "ok", json_boolean(error == NULL));
	if (id != NULL) {
		json_object_set(reply, "id", id);
	}
	if (error != NULL) {
		struct host_error clean;

		/* It may quote what the client wrote, which need not be text. */
		snprintf(clean.text, sizeof(clean.text), "%s", error);
		for (char *c = clean.text; *c != '\0'; c++) {
			*c = *c >= ' ' && *c <= '~' ? *c : '?';
		}
		control_put_string(reply, "error", clean.text);
		state.errors++;
	} else if (body != NULL) {
		json_object_update(reply, body);
	}
	send_line(client, reply);
	json_decref(reply);
	json_decref(body);
}

void control_reply(json_t *body, const char *error)
{
	json_t *id = NULL;

	if (!state.pending) {
		json_decref(body);
		return;
	}
	state.pending = false;
	maybe_lines = true;
	if (state.pending_client < 0) {
		json_decref(body);
		return;
	}
	if (state.pending_id[0] != '\0') {
		id = json_loads(state.pending_id, JSON_DECODE_ANY, NULL);
	}
	answer(&clients[state.pending_client], body, id, error);
	json_decref(id);
}

/* --- requests ------------------------------------------------------------------------------------
 */

static const struct control_op *find_op(const char *name)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);

	for (size_t i = 0; i < count; i++) {
		const struct control_op *op = modules[i]->ops;

		for (; op != NULL && op->name != NULL; op++) {
			if (strcmp(op->name, name) == 0) {
				return op;
			}
		}
	}
	return NULL;
}

static void set_pending(struct client *client, const json_t *id)
{
	char *text = id != NULL ? json_dumps(id, JSON_COMPACT | JSON_ENCODE_ANY) : NULL;

	state.pending = true;
	state.pending_client = (int)(client - clients);
	state.pending_id[0] = '\0';
	if (text != NULL && strlen(text) < sizeof(state.pending_id)) {
		strcpy(state.pending_id, text);
	}
	free(text);
}

static void run(struct client *client, json_t *request)
{
	const char *name = json_string_value(json_object_get(request, "op"));
	const struct control_op *op = find_op(name);
	json_t *id = json_object_get(request, "id");
	struct host_error error;
	struct control_call call = {.request = request, .reply = json_object(), .error = &error};
	enum control_result result;

	if (op == NULL) {
		host_error_set(&error, "unknown op \"%.60s\"; {\"op\":\"ops\"} lists all", name);
		answer(client, call.reply, id, error.text);
		return;
	}
	/* Before it runs: a reset carries this over. */
	set_pending(client, id);
	result = op->run(&call);
	if (result == CONTROL_LATER) {
		json_decref(call.reply);
		if (client->gone) {
			abandon();
		}
		return;
	}
	state.pending = false;
	answer(client, call.reply, id, result == CONTROL_OK ? NULL : error.text);
}

static void run_line(struct client *client, const char *line, size_t length)
{
	struct host_error error;
	json_t *request;

	if (length > 0 && line[length - 1] == '\r') {
		length--;
	}
	if (length == 0) {
		return;
	}
	state.requests++;
	request = control_decode(line, length, &error);
	if (request == NULL) {
		answer(client, NULL, NULL, error.text);
		return;
	}
	run(client, request);
	json_decref(request);
}

/* One line of this client; false: it has no whole one. */
static bool run_client(struct client *client)
{
	const size_t length = buffer_length(&client->in);
	const uint8_t *end = length > 0 ? memchr(buffer_bytes(&client->in), '\n', length) : NULL;
	struct buffer line = {0};
	struct host_error error;
	size_t n;

	if (end == NULL) {
		if (length > CONTROL_LINE_MAX) {
			if (!client->skipping) {
				control_decode(NULL, length, &error);
				answer(client, NULL, NULL, error.text);
			}
			client->skipping = true;
			buffer_consume(&client->in, length);
		}
		return false;
	}
	n = (size_t)(end - buffer_bytes(&client->in));
	if (client->skipping) {
		client->skipping = false;
		buffer_consume(&client->in, n + 1);
		return true;
	}
	/* Out of the buffer first: the operation may be a reset, which never returns. */
	buffer_append(&line, buffer_bytes(&client->in), n, INPUT_MAX);
	buffer_consume(&client->in, n + 1);
	run_line(client, n > 0 ? (const char *)line.data : "", n);
	buffer_free(&line);
	return true;
}

void control_quit(void)
{
	quitting = true;
}

static void close_client(struct client *client)
{
	loop_remove(&client->source);
	close(client->source.fd);
	buffer_free(&client->in);
	buffer_free(&client->out);
	client->open = false;
}

bool control_run_one(void)
{
	if (!maybe_lines || state.pending) {
		return false;
	}
	for (unsigned int i = 0; i < CLIENTS_MAX; i++) {
		struct client *client = &clients[(next_client + i) % CLIENTS_MAX];

		if (!client->open) {
			continue;
		}
		if (run_client(client)) {
			next_client = (next_client + i + 1) % CLIENTS_MAX;
			if (!client->gone) {
				update(client);
			}
			if (quitting) {
				port_exit(0);
			}
			return true;
		}
		if (client->gone || (client->ended && buffer_length(&client->out) == 0)) {
			close_client(client);
		} else {
			update(client);
		}
	}
	maybe_lines = false;
	return false;
}

/* --- connections ---------------------------------------------------------------------------------
 */

static void on_ready(struct loop_source *source, uint32_t events)
{
	static uint8_t bytes[16384];
	struct client *client = source->owner;
	ssize_t n = 1;

	if ((events & EPOLLOUT) != 0) {
		drain(client);
	}
	while (n > 0 && !client->ended && buffer_length(&client->in) < INPUT_MAX) {
		n = recv(source->fd, bytes, sizeof(bytes), MSG_DONTWAIT);
		if (n > 0) {
			buffer_append(&client->in, bytes, (size_t)n, SIZE_MAX / 2);
		} else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
			client->ended = true;
		}
	}
	if ((events & (EPOLLHUP | EPOLLERR)) != 0 && client->ended) {
		set_gone(client);
	}
	maybe_lines = true;
	if (!client->gone) {
		update(client);
	}
}

static void add_client(struct client *client, int fd)
{
	client->open = true;
	client->gone = false;
	client->source = (struct loop_source){.fd = fd, .ready = on_ready, .owner = client};
	loop_add(&client->source, EPOLLIN);
}

static void stop_listening(int error)
{
	if (!state.is_deaf) {
		host_say("--control: no more clients for now: %s", strerror(error));
	}
	state.is_deaf = true;
	state.errors++;
	loop_want(&listener, 0);
	loop_timer_start(&listen_again, ACCEPT_AGAIN_MS);
}

static void on_listen_again(struct loop_timer *timer)
{
	(void)timer;
	loop_want(&listener, EPOLLIN);
}

static void on_client(struct loop_source *source, uint32_t events)
{
	const int fd = accept4(source->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);

	(void)events;
	if (fd < 0) {
		if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) {
			stop_listening(errno);
		}
		return;
	}
	state.is_deaf = false;
	for (int i = 0; i < CLIENTS_MAX; i++) {
		if (!clients[i].open) {
			clients[i].ended = false;
			clients[i].skipping = false;
			add_client(&clients[i], fd);
			return;
		}
	}
	state.errors++;
	close(fd);
}

/* --- carried over a reset ------------------------------------------------------------------------
 */

static void save(void)
{
	if (path == NULL) {
		return;
	}
	carry_put("control/name", &own, sizeof(own));
	carry_fd(own.fd);
	carry_fd(own.claim);
	for (int i = 0; i < CLIENTS_MAX; i++) {
		struct client *client = &clients[i];
		const struct client_carried carried = {
			.fd = client->source.fd,
			.in_length = (uint32_t)buffer_length(&client->in),
			.out_length = (uint32_t)buffer_length(&client->out),
			.ended = client->ended,
			.skipping = client->skipping,
		};
		struct buffer data = {0};
		char name[32];

		if (!client->open || client->gone) {
			continue;
		}
		snprintf(name, sizeof(name), "control/client%d", i);
		buffer_append(&data, &carried, sizeof(carried), SIZE_MAX / 2);
		buffer_append(&data, buffer_bytes(&client->in), carried.in_length, SIZE_MAX / 2);
		buffer_append(&data, buffer_bytes(&client->out), carried.out_length, SIZE_MAX / 2);
		carry_put(name, buffer_bytes(&data), buffer_length(&data));
		carry_fd(client->source.fd);
		buffer_free(&data);
	}
}

static void restore_client(int i)
{
	struct client *client = &clients[i];
	struct client_carried carried;
	char name[32];
	size_t size;
	const uint8_t *data;

	snprintf(name, sizeof(name), "control/client%d", i);
	data = carry_get(name, &size);
	if (data == NULL || size < sizeof(carried)) {
		return;
	}
	memcpy(&carried, data, sizeof(carried));
	data += sizeof(carried);
	if (size != sizeof(carried) + carried.in_length + carried.out_length) {
		return;
	}
	buffer_append(&client->in, data, carried.in_length, SIZE_MAX / 2);
	buffer_append(&client->out, data + carried.in_length, carried.out_length, SIZE_MAX / 2);
	client->ended = carried.ended;
	client->skipping = carried.skipping;
	add_client(client, carried.fd);
	update(client);
	maybe_lines = true;
}

static int start(void)
{
	size_t size;
	const void *old;
	int error = 0;

	if (path == NULL) {
		return 0;
	}
	carry_register("control", &state, sizeof(state));
	old = carry_get("control/name", &size);
	if (old != NULL && size == sizeof(own)) {
		memcpy(&own, old, size);
		for (int i = 0; i < CLIENTS_MAX; i++) {
			restore_client(i);
		}
	} else {
		error = named_socket_open(&own, path, CLIENTS_MAX);
	}
	if (error != 0) {
		host_say("--control: %s: %s", path,
		         error == -EADDRINUSE ? "another light has it" : strerror(-error));
		return -1;
	}
	listener.fd = own.fd;
	listener.ready = on_client;
	listen_again.fire = on_listen_again;
	loop_add(&listener, EPOLLIN);
	return 0;
}

static void stop(void)
{
	if (path == NULL) {
		return;
	}
	for (int i = 0; i < CLIENTS_MAX; i++) {
		if (clients[i].open) {
			close_client(&clients[i]);
		}
	}
	loop_remove(&listener);
	loop_timer_stop(&listen_again);
	named_socket_close(&own, path);
}

static int parse_control(const char *value, struct host_error *error)
{
	struct sockaddr_un address;

	if (value[0] == '\0' || strlen(value) >= sizeof(address.sun_path)) {
		return host_error_set(error, "a path of 1 to %zu characters is needed",
		                      sizeof(address.sun_path) - 1);
	}
	path = value;
	clock_control();
	return 0;
}

static const struct host_option options[] = {
	{"control", "PATH",
         "open a control socket: JSON lines that move virtual time, read\n"
         "outputs, inject faults (boards/native/CONTROL.md)",
         parse_control},
	{0},
};

HOST_MODULE(control_module) = {
	.name = "control",
	.order = HOST_ORDER_CONTROL,
	.options = options,
	.start = start,
	.save = save,
	.stop = stop,
};
