/* SPDX-License-Identifier: Apache-2.0 */
#include "can_controller.h"

#include <string.h>

#include "can_frame_time.h"

/* ISO 11898-1, fault confinement */
#define WARNING_AT    96u
#define PASSIVE_AT    128u
#define BUS_OFF_AT    256u
#define TX_ERROR_STEP 8u
#define RX_PASSIVE_TO 119u /* a good frame takes a passive receiver's counter here */
#define RECOVERY_BITS (128u * 11u)

_Static_assert(CAN_HOST_EXTENDED == CAN_FRAME_IDE && CAN_HOST_REMOTE == CAN_FRAME_RTR &&
                       CAN_HOST_FD == CAN_FRAME_FDF && CAN_HOST_BRS == CAN_FRAME_BRS &&
                       CAN_HOST_ESI == CAN_FRAME_ESI,
               "flags of frames are the same on both sides");
_Static_assert((int)CAN_HOST_ACTIVE == (int)CAN_STATE_ERROR_ACTIVE &&
                       (int)CAN_HOST_WARNING == (int)CAN_STATE_ERROR_WARNING &&
                       (int)CAN_HOST_PASSIVE == (int)CAN_STATE_ERROR_PASSIVE &&
                       (int)CAN_HOST_BUS_OFF == (int)CAN_STATE_BUS_OFF,
               "states are the same on both sides");

static uint64_t now_us(void)
{
	return k_ticks_to_us_floor64((uint64_t)k_uptime_ticks());
}

/* --- states ---------------------------------------------------------------------------------- */

struct can_bus_err_cnt can_controller_errors(const struct can_controller *self)
{
	return (struct can_bus_err_cnt){
		.tx_err_cnt = (uint8_t)MIN(self->tx_errors, UINT8_MAX),
		.rx_err_cnt = (uint8_t)MIN(self->rx_errors, UINT8_MAX),
	};
}

static void change_state(struct can_controller *self, enum can_state state)
{
	if (self->state != state) {
		self->state = state;
		if (self->state_callback != NULL) {
			self->state_callback(self->dev, state, can_controller_errors(self),
			                     self->state_user_data);
		}
	}
}

static void finish(struct can_controller *self, uint32_t index, int error)
{
	struct can_controller_mailbox *mailbox = &self->mailboxes[index];

	mailbox->used = false;
	k_sem_give(&self->mailboxes_free);
	mailbox->callback(self->dev, error, mailbox->user_data);
}

static void abort_all(struct can_controller *self, int error)
{
	k_timer_stop(&self->frame_timer);
	self->occupied = false;
	self->waiting = false;
	for (uint32_t i = 0; i < self->mailbox_count; i++) {
		if (self->mailboxes[i].used) {
			finish(self, i, error);
		}
	}
}

void can_controller_recover(struct can_controller *self)
{
	const uint64_t us = now_us();
	const uint64_t start_us = MAX(us, self->hold_until_us);
	const uint64_t bits_us =
		(RECOVERY_BITS * UINT64_C(1000000) + self->bitrate - 1) / self->bitrate;

	k_timer_start(&self->recovery_timer, K_TIMEOUT_ABS_US((int64_t)(start_us + bits_us)),
	              K_NO_WAIT);
}

static void go_bus_off(struct can_controller *self, uint32_t hold_us)
{
	self->tx_errors = MAX(self->tx_errors, BUS_OFF_AT);
	self->hold_until_us = now_us() + hold_us;
	change_state(self, CAN_STATE_BUS_OFF);
	abort_all(self, -ENETUNREACH);
	if (!can_host_bus_is_real(self->bus) && (self->mode & CAN_MODE_MANUAL_RECOVERY) == 0) {
		can_controller_recover(self);
	}
}

/* The state that the counters say. */
static void judge(struct can_controller *self)
{
	const uint32_t errors = MAX(self->tx_errors, self->rx_errors);

	if (self->state == CAN_STATE_BUS_OFF) {
		return;
	}
	if (self->tx_errors >= BUS_OFF_AT) {
		go_bus_off(self, 0);
	} else if (errors >= PASSIVE_AT) {
		change_state(self, CAN_STATE_ERROR_PASSIVE);
	} else if (errors >= WARNING_AT) {
		change_state(self, CAN_STATE_ERROR_WARNING);
	} else {
		change_state(self, CAN_STATE_ERROR_ACTIVE);
	}
}

static void on_recovered(struct k_timer *timer)
{
	struct can_controller *self = CONTAINER_OF(timer, struct can_controller, recovery_timer);

	self->tx_errors = 0;
	self->rx_errors = 0;
	change_state(self, CAN_STATE_ERROR_ACTIVE);
	k_sem_give(&self->recovered);
	native_irq_raise(&self->irq);
}

/* --- receiving ------------------------------------------------------------------------------- */

static void deliver(struct can_controller *self, const struct can_host_frame *from)
{
	struct can_frame frame = {
		.id = from->id,
		.dlc = can_bytes_to_dlc(from->length),
		.flags = from->flags,
	};

	if ((from->flags & CAN_HOST_REMOTE) != 0 && !IS_ENABLED(CONFIG_CAN_ACCEPT_RTR)) {
		return;
	}
	memcpy(frame.data, from->data, MIN(from->length, sizeof(frame.data)));
	for (size_t i = 0; i < CAN_CONTROLLER_FILTERS; i++) {
		const struct can_controller_filter filter = self->filters[i];

		if (filter.callback != NULL && can_frame_matches_filter(&frame, &filter.filter)) {
			struct can_frame copy = frame;

			filter.callback(self->dev, &copy, filter.user_data);
		}
	}
}

static void receive(struct can_controller *self, const struct can_host_frame *frame)
{
	if (self->state == CAN_STATE_BUS_OFF || (self->mode & CAN_MODE_LOOPBACK) != 0) {
		return;
	}
	if ((frame->flags & CAN_HOST_FD) != 0 && (self->mode & CAN_MODE_FD) == 0) {
		self->stats.form_error++;
		return;
	}
	if (!can_host_bus_is_real(self->bus) && self->rx_errors > 0) {
		self->rx_errors =
			self->rx_errors >= PASSIVE_AT ? RX_PASSIVE_TO : self->rx_errors - 1;
		judge(self);
	}
	deliver(self, frame);
}

static void note_error(struct can_controller *self, uint32_t *counter)
{
	(*counter)++;
	if (!can_host_bus_is_real(self->bus)) {
		self->rx_errors = MIN(self->rx_errors + 1, UINT8_MAX);
		judge(self);
	}
}

static void take_state(struct can_controller *self, const struct can_host_event *event)
{
	self->tx_errors = event->tx_errors;
	self->rx_errors = event->rx_errors;
	if (event->state == CAN_HOST_BUS_OFF) {
		go_bus_off(self, 0);
	} else {
		change_state(self, (enum can_state)event->state);
	}
}

static void handle(struct can_controller *self, const struct can_host_event *event)
{
	if (!self->started) {
		return;
	}
	switch (event->kind) {
	case CAN_HOST_FRAME:
		receive(self, &event->frame);
		break;
	case CAN_HOST_BIT0_ERROR:
		note_error(self, &self->stats.bit0_error);
		break;
	case CAN_HOST_BIT1_ERROR:
		note_error(self, &self->stats.bit1_error);
		break;
	case CAN_HOST_STUFF_ERROR:
		note_error(self, &self->stats.stuff_error);
		break;
	case CAN_HOST_CRC_ERROR:
		note_error(self, &self->stats.crc_error);
		break;
	case CAN_HOST_FORM_ERROR:
		note_error(self, &self->stats.form_error);
		break;
	case CAN_HOST_ACK_ERROR:
		note_error(self, &self->stats.ack_error);
		break;
	case CAN_HOST_OVERRUN:
		self->stats.rx_overrun++;
		break;
	case CAN_HOST_FORCE_BUS_OFF:
		go_bus_off(self, event->hold_us);
		break;
	case CAN_HOST_STATE:
		take_state(self, event);
		break;
	}
}

/* --- transmitting ---------------------------------------------------------------------------- */

/* The mailbox that wins among the own ones; -1: none, or it cannot be sent now. */
static int choose(const struct can_controller *self)
{
	uint32_t best_priority = 0;
	int best = -1;

	if (!self->started || self->waiting || self->state == CAN_STATE_BUS_OFF) {
		return -1;
	}
	for (uint32_t i = 0; i < self->mailbox_count; i++) {
		const struct can_controller_mailbox *mailbox = &self->mailboxes[i];
		uint32_t priority;

		if (!mailbox->used) {
			continue;
		}
		priority = can_frame_priority(&mailbox->frame);
		if (best < 0 || priority < best_priority ||
		    (priority == best_priority &&
		     (int32_t)(mailbox->order - self->mailboxes[best].order) < 0)) {
			best = (int)i;
			best_priority = priority;
		}
	}
	return best;
}

static void on_sent(struct can_controller *self, uint32_t index)
{
	const struct can_host_frame frame = self->mailboxes[index].frame;

	if (!can_host_bus_is_real(self->bus) && self->tx_errors > 0) {
		self->tx_errors--;
		judge(self);
	}
	finish(self, index, 0);
	if ((self->mode & CAN_MODE_LOOPBACK) != 0) {
		deliver(self, &frame);
	}
}

/* An error frame hit it: again, unless that was one too many. */
static void on_destroyed(struct can_controller *self, uint32_t index)
{
	self->stats.bit1_error++;
	if (can_host_bus_is_real(self->bus)) {
		finish(self, index, -EIO);
		return;
	}
	self->tx_errors += TX_ERROR_STEP;
	if ((self->mode & CAN_MODE_ONE_SHOT) != 0) {
		finish(self, index, -EIO);
	}
	judge(self);
}

/* A missing acknowledgement makes a transmitter passive within 16 attempts, and no more than that.
 */
static void on_nobody(struct can_controller *self, uint32_t index)
{
	self->stats.ack_error++;
	self->tx_errors = MAX(self->tx_errors, PASSIVE_AT);
	if ((self->mode & CAN_MODE_ONE_SHOT) != 0) {
		finish(self, index, -EIO);
	} else {
		self->waiting = true;
	}
	judge(self);
}

static void transmit(struct can_controller *self, uint32_t index)
{
	enum can_host_result result = CAN_HOST_SENT;

	if ((self->mode & CAN_MODE_LOOPBACK) == 0) {
		result = can_host_bus_send(self->bus, &self->mailboxes[index].frame);
	}
	switch (result) {
	case CAN_HOST_SENT:
		on_sent(self, index);
		break;
	case CAN_HOST_DESTROYED:
		on_destroyed(self, index);
		break;
	case CAN_HOST_NOBODY:
		on_nobody(self, index);
		break;
	case CAN_HOST_BUSY:
		self->waiting = true;
		break;
	}
}

/* --- a bus that is infinitely fast ------------------------------------------------------------ */

static bool take_event(struct can_controller *self)
{
	const struct can_host_event *first = can_host_bus_peek(self->bus);
	struct can_host_event event;

	if (first == NULL) {
		return false;
	}
	event = *first;
	can_host_bus_drop(self->bus);
	handle(self, &event);
	return true;
}

static void run_fast(struct can_controller *self)
{
	int index;

	do {
		while (take_event(self)) {
		}
		index = choose(self);
		if (index >= 0) {
			transmit(self, (uint32_t)index);
		}
	} while (index >= 0);
}

/* --- a bus that takes its time ---------------------------------------------------------------- */

static void occupy(struct can_controller *self, const struct can_host_frame *frame,
                   uint64_t start_ns)
{
	self->occupied = true;
	self->free_ns = start_ns + can_frame_time_ns(frame, self->bitrate, self->bitrate_data);
	k_timer_start(&self->frame_timer, K_TIMEOUT_ABS_NS((int64_t)self->free_ns), K_NO_WAIT);
}

/* The bus is free at start_ns: who waits for it? */
static void arbitrate(struct can_controller *self, uint64_t start_ns)
{
	while (!self->occupied) {
		const struct can_host_event *event = can_host_bus_peek(self->bus);
		const int own = choose(self);

		if (event != NULL && event->kind != CAN_HOST_FRAME) {
			take_event(self);
		} else if (event != NULL &&
		           (own < 0 || can_frame_priority(&event->frame) <=
		                               can_frame_priority(&self->mailboxes[own].frame))) {
			self->own = -1;
			self->foreign = event->frame;
			can_host_bus_drop(self->bus);
			occupy(self, &self->foreign, start_ns);
			if (own >= 0 && (self->mode & CAN_MODE_ONE_SHOT) != 0) {
				finish(self, (uint32_t)own, -EBUSY);
			}
		} else if (own >= 0) {
			self->own = own;
			occupy(self, &self->mailboxes[own].frame, start_ns);
		} else {
			break;
		}
	}
}

static void on_frame_end(struct k_timer *timer)
{
	struct can_controller *self = CONTAINER_OF(timer, struct can_controller, frame_timer);

	self->occupied = false;
	if (self->own >= 0) {
		transmit(self, (uint32_t)self->own);
	} else if (self->started) {
		receive(self, &self->foreign);
	}
	arbitrate(self, self->free_ns);
}

static void isr(void *arg)
{
	struct can_controller *self = arg;

	if (self->paced) {
		arbitrate(self, MAX(now_us() * 1000u, self->free_ns));
	} else {
		run_fast(self);
	}
}

/* --- from outside ---------------------------------------------------------------------------- */

static void on_event(void *arg)
{
	struct can_controller *self = arg;

	native_irq_raise(&self->irq);
}

static void on_ready(void *arg)
{
	struct can_controller *self = arg;

	self->waiting = false;
	if (can_host_bus_is_real(self->bus) && self->state != CAN_STATE_BUS_OFF) {
		self->tx_errors = 0;
		judge(self);
	}
	native_irq_raise(&self->irq);
}

void can_controller_post(struct can_controller *self, const struct can_host_frame *frame,
                         can_tx_callback_t callback, void *user_data)
{
	const unsigned int key = irq_lock();
	uint32_t i = 0;

	while (i < self->mailbox_count && self->mailboxes[i].used) {
		i++;
	}
	__ASSERT(i < self->mailbox_count, "a mailbox is free");
	self->mailboxes[i] = (struct can_controller_mailbox){
		.used = true,
		.order = self->next_order++,
		.frame = *frame,
		.callback = callback,
		.user_data = user_data,
	};
	irq_unlock(key);
	native_irq_raise(&self->irq);
}

void can_controller_start(struct can_controller *self)
{
	self->tx_errors = 0;
	self->rx_errors = 0;
	self->state = CAN_STATE_ERROR_ACTIVE;
	self->started = true;
}

void can_controller_stop(struct can_controller *self)
{
	const unsigned int key = irq_lock();

	self->started = false;
	k_timer_stop(&self->recovery_timer);
	abort_all(self, -ENETDOWN);
	irq_unlock(key);
}

void can_controller_init(struct can_controller *self, const struct device *dev, struct can_bus *bus)
{
	const struct can_host_client client = {on_event, on_ready, self};

	self->dev = dev;
	self->bus = bus;
	self->irq = (struct native_irq){.isr = isr, .arg = self};
	self->paced = can_host_bus_is_paced(bus);
	k_sem_init(&self->mailboxes_free, self->mailbox_count, self->mailbox_count);
	k_sem_init(&self->recovered, 0, 1);
	k_timer_init(&self->recovery_timer, on_recovered, NULL);
	k_timer_init(&self->frame_timer, on_frame_end, NULL);
	can_host_bus_open(bus, &client);
}
