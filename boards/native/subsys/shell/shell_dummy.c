/* SPDX-License-Identifier: Apache-2.0 */
#include <zephyr/init.h>
#include <zephyr/shell/shell_dummy.h>

#include <string.h>

#define INPUT_MAX 512

static char output[CONFIG_SHELL_BACKEND_DUMMY_BUF_SIZE];
static size_t output_len;
static char input[INPUT_MAX];
static size_t input_len;
static size_t input_at;
static shell_transport_handler_t event;
static void *event_context;

static int dummy_init(const struct shell_transport *transport, const void *config,
                      shell_transport_handler_t evt_handler, void *context)
{
	event = evt_handler;
	event_context = context;
	return 0;
}

static int dummy_uninit(const struct shell_transport *transport)
{
	return 0;
}

static int dummy_enable(const struct shell_transport *transport, bool blocking_tx)
{
	return 0;
}

static int dummy_write(const struct shell_transport *transport, const void *data, size_t length,
                       size_t *cnt)
{
	const size_t room = sizeof(output) - 1 - output_len;
	const size_t kept = length < room ? length : room;

	memcpy(&output[output_len], data, kept);
	output_len += kept;
	output[output_len] = '\0';
	*cnt = length;
	return 0;
}

static int dummy_read(const struct shell_transport *transport, void *data, size_t length,
                      size_t *cnt)
{
	const size_t left = input_len - input_at;

	*cnt = left < length ? left : length;
	memcpy(data, &input[input_at], *cnt);
	input_at += *cnt;
	return 0;
}

static const struct shell_transport_api api = {
	.init = dummy_init,
	.uninit = dummy_uninit,
	.enable = dummy_enable,
	.write = dummy_write,
	.read = dummy_read,
};
static const struct shell_transport transport = {.api = &api};

SHELL_DEFINE(shell_dummy, "~$ ", &transport, 1, 0, SHELL_FLAG_CRLF_DEFAULT);

const struct shell *shell_backend_dummy_get_ptr(void)
{
	return &shell_dummy;
}

const char *shell_backend_dummy_get_output(const struct shell *sh, size_t *sizep)
{
	output[output_len] = '\0';
	*sizep = output_len;
	output_len = 0;
	return output;
}

void shell_backend_dummy_clear_output(const struct shell *sh)
{
	output_len = 0;
	output[0] = '\0';
}

size_t shell_backend_dummy_push_input(const struct shell *sh, const void *data, size_t length)
{
	const size_t taken = length < sizeof(input) ? length : sizeof(input);

	/* What the shell has not read yet is replaced: tests let it run in between. */
	memcpy(input, data, taken);
	input_len = taken;
	input_at = 0;
	event(SHELL_TRANSPORT_EVT_RX_RDY, event_context);
	return taken;
}

static int start(void)
{
	const struct shell_backend_config_flags flags = SHELL_DEFAULT_BACKEND_CONFIG_FLAGS;

	return shell_init(&shell_dummy, NULL, flags, false, 0);
}

SYS_INIT(start, POST_KERNEL, 0);
