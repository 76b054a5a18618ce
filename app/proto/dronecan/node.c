/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/node.h"

#include <string.h>

#include "core/assert.h"

static const struct device_who who = {.way = SECURITY_WAY_DRONECAN};

#define STATUS_PERIOD_US ((int64_t)DRONECAN_NODE_STATUS_MAX_BROADCASTING_PERIOD_MS * US_PER_MS)
/* Time for the answer to leave before the reset. */
#define RESTART_DELAY_US (50 * US_PER_MS)
#define PRIORITY_STATUS  24u
#define PRIORITY_LOG     28u

static bool is_anonymous(const struct dronecan_node *self)
{
	return self->transport->node_id == 0;
}

void dronecan_node_init(struct dronecan_node *self, int64_t now_us,
                        const struct dronecan_node_config *config,
                        struct dronecan_transport *transport, struct pharos_device *device)
{
	static const uint8_t zeros[DRONECAN_UNIQUE_ID_SIZE];

	PHAROS_ASSERT(memcmp(config->unique_id, zeros, sizeof(zeros)) != 0);
	PHAROS_ASSERT(strlen(config->name) <=
	              sizeof(((struct dronecan_get_node_info_response *)0)->name));
	memset(self, 0, sizeof(*self));
	self->config = config;
	self->transport = transport;
	self->device = device;
	self->condition.mode = DRONECAN_NODE_STATUS_MODE_INITIALIZATION;
	self->status_us = now_us;
	self->restart_us = TIME_NEVER_US;
	dronecan_clash_init(&self->clash);
	dronecan_allocation_init(&self->allocation, config->unique_id, config->preferred_id);
	if (is_anonymous(self)) {
		dronecan_allocation_start(&self->allocation, now_us, transport);
	}
}

void dronecan_node_set_condition(struct dronecan_node *self, int64_t now_us,
                                 const struct dronecan_node_condition *condition)
{
	if (condition->health != self->condition.health ||
	    condition->mode != self->condition.mode) {
		self->status_us = now_us;
	}
	self->condition = *condition;
}

void dronecan_node_set_bus_errors(struct dronecan_node *self, uint64_t bus_errors)
{
	self->bus_errors = bus_errors;
}

static struct dronecan_node_status status(const struct dronecan_node *self, int64_t now_us)
{
	return (struct dronecan_node_status){
		.uptime_sec = (uint32_t)(now_us / US_PER_S),
		.health = self->condition.health,
		.mode = self->condition.mode,
		.vendor_specific_status_code = self->condition.vendor_code,
	};
}

bool dronecan_node_respond(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *request, const uint8_t *data,
                           size_t size)
{
	const struct dronecan_transfer response = {
		.type = request->type,
		.kind = DRONECAN_RESPONSE,
		.target = request->source,
		.priority = request->priority,
		.id = request->id,
		.fd = request->fd,
		.data = data,
		.size = size,
	};
	const bool queued = dronecan_transport_send(self->transport, now_us, &response);

	self->stats.unanswered += queued ? 0u : 1u;
	return queued;
}

/* Whether an answer to this request goes out in the encoding of classic CAN. */
static bool answers_with_tao(const struct dronecan_node *self,
                             const struct dronecan_transfer *request)
{
	return !(request->fd && self->transport->fd);
}

static void send_status(struct dronecan_node *self, int64_t now_us)
{
	const struct dronecan_node_status message = status(self, now_us);
	uint8_t data[DRONECAN_NODE_STATUS_MAX_SIZE];
	struct dronecan_transfer transfer = {
		.type = &dronecan_node_status_type,
		.kind = DRONECAN_MESSAGE,
		.priority = PRIORITY_STATUS,
		.fd = true,
		.data = data,
	};

	if (dronecan_node_status_encode(&message, false, data, sizeof(data), &transfer.size)) {
		/* No room: counted there, and the next one is a second away. */
		(void)dronecan_transport_send(self->transport, now_us, &transfer);
	}
}

static void get_node_info(struct dronecan_node *self, int64_t now_us,
                          const struct dronecan_transfer *request)
{
	struct dronecan_get_node_info_response response = {
		.status = status(self, now_us),
		.software_version =
			{
				.major = self->config->software_major,
				.minor = self->config->software_minor,
				.vcs_commit = self->config->vcs_commit,
			},
		.hardware_version =
			{
				.major = self->config->hardware_major,
				.minor = self->config->hardware_minor,
			},
		.name_len = (uint8_t)strlen(self->config->name),
	};
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
	size_t size;

	if (self->config->vcs_commit != 0) {
		response.software_version.optional_field_flags =
			DRONECAN_SOFTWARE_VERSION_OPTIONAL_FIELD_FLAG_VCS_COMMIT;
	}
	memcpy(response.hardware_version.unique_id, self->config->unique_id,
	       DRONECAN_UNIQUE_ID_SIZE);
	memcpy(response.name, self->config->name, response.name_len);
	if (dronecan_get_node_info_response_encode(&response, answers_with_tao(self, request), data,
	                                           sizeof(data), &size)) {
		(void)dronecan_node_respond(self, now_us, request, data, size);
	}
}

static void get_transport_stats(struct dronecan_node *self, int64_t now_us,
                                const struct dronecan_transfer *request)
{
	const struct dronecan_transport_stats *stats = &self->transport->stats;
	const struct dronecan_get_transport_stats_response response = {
		.transfers_tx = stats->transfers_tx,
		.transfers_rx = stats->transfers_rx,
		.transfer_errors = dronecan_transport_rx_errors(self->transport) +
	                           stats->tx_evicted + stats->tx_no_room + stats->tx_expired,
		.can_iface_stats_len = 1,
		.can_iface_stats = {{
			.frames_tx = stats->frames_tx,
			.frames_rx = stats->frames_rx,
			.errors = self->bus_errors,
		}},
	};
	uint8_t data[DRONECAN_GET_TRANSPORT_STATS_RESPONSE_MAX_SIZE];
	size_t size;

	if (dronecan_get_transport_stats_response_encode(&response, answers_with_tao(self, request),
	                                                 data, sizeof(data), &size)) {
		(void)dronecan_node_respond(self, now_us, request, data, size);
	}
}

void dronecan_node_restart(struct dronecan_node *self, int64_t now_us)
{
	if (self->restart_us == TIME_NEVER_US) {
		self->restart_us = now_us + RESTART_DELAY_US;
	}
}

static void restart_node(struct dronecan_node *self, int64_t now_us,
                         const struct dronecan_transfer *request)
{
	struct dronecan_restart_node_request message;
	struct dronecan_restart_node_response response;
	uint8_t data[DRONECAN_RESTART_NODE_RESPONSE_MAX_SIZE];
	size_t size;

	if (!dronecan_restart_node_request_decode(&message, !request->fd, request->data,
	                                          request->size)) {
		self->stats.malformed++;
		return;
	}
	response.ok = message.magic_number == DRONECAN_RESTART_NODE_MAGIC_NUMBER &&
	              pharos_device_may(self->device, &who, SECURITY_RESTART);
	if (!dronecan_restart_node_response_encode(&response, true, data, sizeof(data), &size)) {
		return;
	}
	/* Without an answer nothing happens: the asker will ask again. */
	if (dronecan_node_respond(self, now_us, request, data, size) && response.ok) {
		dronecan_node_restart(self, now_us);
	}
}

static void allocation_received(struct dronecan_node *self, int64_t now_us,
                                const struct dronecan_transfer *transfer,
                                struct dronecan_node_outbox *out)
{
	const uint8_t node_id =
		dronecan_allocation_receive(&self->allocation, now_us, self->transport, transfer);

	if (node_id != 0) {
		dronecan_transport_set_node_id(self->transport, node_id);
		self->status_us = now_us;
		out->actions[out->count++] = (struct dronecan_node_action){
			.kind = DRONECAN_NODE_ID_ALLOCATED,
			.node_id = node_id,
		};
	}
}

void dronecan_node_receive(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *transfer,
                           struct dronecan_node_outbox *out)
{
	out->count = 0;
	if (transfer->type == &dronecan_dynamic_node_id_allocation_type) {
		allocation_received(self, now_us, transfer, out);
		return;
	}
	dronecan_clash_receive(&self->clash, now_us, self->transport, self->config->unique_id,
	                       transfer);
	if (transfer->kind != DRONECAN_REQUEST) {
		return;
	}
	self->stats.requests++;
	if (transfer->type == &dronecan_get_node_info_type) {
		if (!dronecan_clash_delays(&self->clash, now_us, self->transport, transfer)) {
			get_node_info(self, now_us, transfer);
		}
	} else if (transfer->type == &dronecan_get_transport_stats_type) {
		get_transport_stats(self, now_us, transfer);
	} else if (transfer->type == &dronecan_restart_node_type) {
		restart_node(self, now_us, transfer);
	} else if (transfer->type == &dronecan_param_get_set_type) {
		dronecan_node_get_set(self, now_us, transfer);
	} else if (transfer->type == &dronecan_param_execute_opcode_type) {
		dronecan_node_execute_opcode(self, now_us, transfer, out);
	}
}

void dronecan_node_step(struct dronecan_node *self, int64_t now_us,
                        struct dronecan_node_outbox *out)
{
	out->count = 0;
	dronecan_allocation_step(&self->allocation, now_us, self->transport);
	if (dronecan_clash_step(&self->clash, now_us, self->transport)) {
		get_node_info(self, now_us, &self->clash.waiting);
	}
	if (!is_anonymous(self) && now_us >= self->status_us) {
		send_status(self, now_us);
		/* Keeps its phase, unless it was held up for more than a period. */
		self->status_us += STATUS_PERIOD_US;
		if (self->status_us <= now_us) {
			self->status_us = now_us + STATUS_PERIOD_US;
		}
	}
	if (now_us >= self->restart_us) {
		self->restart_us = TIME_NEVER_US;
		out->actions[out->count++] =
			(struct dronecan_node_action){.kind = DRONECAN_NODE_RESTART};
	}
}

int64_t dronecan_node_deadline_us(const struct dronecan_node *self)
{
	int64_t deadline_us = dronecan_allocation_deadline_us(&self->allocation);
	const int64_t clash_us = dronecan_clash_deadline_us(&self->clash);

	if (clash_us < deadline_us) {
		deadline_us = clash_us;
	}
	if (!is_anonymous(self) && self->status_us < deadline_us) {
		deadline_us = self->status_us;
	}
	return (self->restart_us < deadline_us) ? self->restart_us : deadline_us;
}

static uint8_t cut(uint8_t *out, size_t limit, const char *text)
{
	const size_t size = strlen(text);
	const size_t count = (size < limit) ? size : limit;

	memcpy(out, text, count);
	return (uint8_t)count;
}

bool dronecan_node_log(struct dronecan_node *self, int64_t now_us, uint8_t level,
                       const char *source, const char *text)
{
	struct dronecan_debug_log_message message = {.level.value = level};
	uint8_t data[DRONECAN_DEBUG_LOG_MESSAGE_MAX_SIZE];
	struct dronecan_transfer transfer = {
		.type = &dronecan_debug_log_message_type,
		.kind = DRONECAN_MESSAGE,
		.priority = PRIORITY_LOG,
		.fd = true,
		.data = data,
	};

	if (is_anonymous(self)) {
		return false;
	}
	message.source_len = cut(message.source, sizeof(message.source), source);
	message.text_len = cut(message.text, sizeof(message.text), text);
	return dronecan_debug_log_message_encode(&message, !self->transport->fd, data, sizeof(data),
	                                         &transfer.size) &&
	       dronecan_transport_send(self->transport, now_us, &transfer);
}
