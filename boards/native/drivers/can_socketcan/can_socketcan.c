/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CAN interface of the system's, by a raw socket. Its controller arbitrates, retransmits and
 * counts errors; error frames tell its state. A frame that the interface's queue took counts as
 * sent. The bit rate and the restart after bus-off are the interface's (ip link set … type can
 * bitrate … restart-ms …): the program changes nothing of it.
 *
 * The interface may be down, or vanish, or come back: the socket is closed and opened again.
 */
#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "../can_host/can_bus.h"

enum {
	READ_BATCH = 32,
	SOCKET_BUFFER = 4 << 20,
	BUSY_RETRY_MS = 1, /* a full queue of the interface wakes nobody when it has room again */
};

struct socketcan {
	struct can_bus *bus;
	char interface[IFNAMSIZ];
	struct loop_source source;
	struct loop_timer busy;
	int fd; /* 0: none */
	bool has_fd_frames;
	uint64_t drops_before; /* of earlier sockets */
};

static struct canfd_frame frames[READ_BATCH];
static struct mmsghdr messages[READ_BATCH];

static int parse(struct can_bus *bus, const char *rest, struct host_error *error)
{
	struct socketcan *socketcan = bus->state;

	if (rest[0] == '\0' || strlen(rest) >= IFNAMSIZ) {
		return host_error_set(
			error, "\"%.40s\": say socketcan:NAME, such as socketcan:can0", bus->url);
	}
	socketcan->bus = bus;
	strcpy(socketcan->interface, rest);
	return 0;
}

/* What did not fit into the socket's receive queue. */
static void count_drops(struct can_bus *bus)
{
	const struct socketcan *socketcan = bus->state;
	uint32_t memory[SK_MEMINFO_VARS] = {0};
	socklen_t size = sizeof(memory);

	if (socketcan->fd > 0 &&
	    getsockopt(socketcan->fd, SOL_SOCKET, SO_MEMINFO, memory, &size) == 0) {
		bus->kept.counts.rx_drops = socketcan->drops_before + memory[SK_MEMINFO_DROPS];
	}
}

/* --- failure --------------------------------------------------------------------------------- */

static void close_socket(struct socketcan *socketcan)
{
	count_drops(socketcan->bus);
	loop_timer_stop(&socketcan->busy);
	loop_remove(&socketcan->source);
	if (socketcan->fd > 0) {
		close(socketcan->fd);
	}
	socketcan->fd = 0;
}

static void fail(struct socketcan *socketcan, const char *what, int error)
{
	close_socket(socketcan);
	can_bus_error(socketcan->bus, what, error);
	can_bus_retry(socketcan->bus);
}

/* --- error frames ---------------------------------------------------------------------------- */

static void tell(struct can_bus *bus, enum can_host_event_kind kind)
{
	can_bus_received(bus, &(struct can_host_event){.kind = kind});
}

static void tell_protocol_errors(struct can_bus *bus, const struct can_frame *frame)
{
	const uint8_t type = frame->data[2];
	const uint8_t location = frame->data[3];

	if ((type & CAN_ERR_PROT_BIT0) != 0) {
		tell(bus, CAN_HOST_BIT0_ERROR);
	}
	if ((type & CAN_ERR_PROT_BIT1) != 0) {
		tell(bus, CAN_HOST_BIT1_ERROR);
	}
	if ((type & CAN_ERR_PROT_STUFF) != 0) {
		tell(bus, CAN_HOST_STUFF_ERROR);
	}
	if ((type & CAN_ERR_PROT_FORM) != 0) {
		tell(bus, CAN_HOST_FORM_ERROR);
	}
	if (location == CAN_ERR_PROT_LOC_CRC_SEQ || location == CAN_ERR_PROT_LOC_CRC_DEL) {
		tell(bus, CAN_HOST_CRC_ERROR);
	}
}

static void tell_state(struct can_bus *bus, enum can_host_state state,
                       const struct can_frame *frame)
{
	struct can_host_event event = {.kind = CAN_HOST_STATE};

	event.state = state;
	/* Where the controller does not tell its counters: the threshold that was passed. */
	if (frame->data[6] != 0 || frame->data[7] != 0) {
		event.tx_errors = frame->data[6];
		event.rx_errors = frame->data[7];
	} else if (state == CAN_HOST_BUS_OFF) {
		event.tx_errors = UINT8_MAX;
	} else if (state != CAN_HOST_ACTIVE) {
		const bool tx =
			(frame->data[1] & (CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_TX_PASSIVE)) != 0;
		const uint8_t count = state == CAN_HOST_PASSIVE ? 128 : 96;

		event.tx_errors = tx ? count : 0;
		event.rx_errors = tx ? 0 : count;
	}
	can_bus_received(bus, &event);
}

static void tell_error(struct can_bus *bus, const struct can_frame *frame)
{
	const uint8_t controller = frame->data[1];

	if ((frame->can_id & CAN_ERR_PROT) != 0) {
		tell_protocol_errors(bus, frame);
	}
	if ((frame->can_id & CAN_ERR_ACK) != 0) {
		tell(bus, CAN_HOST_ACK_ERROR);
	}
	if ((frame->can_id & CAN_ERR_CRTL) != 0) {
		if ((controller & CAN_ERR_CRTL_RX_OVERFLOW) != 0) {
			tell(bus, CAN_HOST_OVERRUN);
		}
		if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
			tell_state(bus, CAN_HOST_PASSIVE, frame);
		} else if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) !=
		           0) {
			tell_state(bus, CAN_HOST_WARNING, frame);
		} else if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) {
			tell_state(bus, CAN_HOST_ACTIVE, frame);
		}
	}
	if ((frame->can_id & CAN_ERR_BUSOFF) != 0) {
		tell_state(bus, CAN_HOST_BUS_OFF, frame);
	}
	if ((frame->can_id & CAN_ERR_RESTARTED) != 0) {
		tell_state(bus, CAN_HOST_ACTIVE, frame);
		can_bus_ready(bus);
	}
}

/* --- receiving ------------------------------------------------------------------------------- */

static void take(struct can_bus *bus, const struct canfd_frame *from, size_t size)
{
	struct can_host_event event = {.kind = CAN_HOST_FRAME};
	struct can_host_frame *frame = &event.frame;

	if ((size != CAN_MTU && size != CANFD_MTU) || from->len > CANFD_MAX_DLEN ||
	    (size == CAN_MTU && from->len > CAN_MAX_DLEN)) {
		can_bus_malformed(bus);
		return;
	}
	if ((from->can_id & CAN_ERR_FLAG) != 0) {
		tell_error(bus, (const struct can_frame *)(const void *)from);
		return;
	}
	if ((from->can_id & CAN_EFF_FLAG) != 0) {
		frame->flags |= CAN_HOST_EXTENDED;
	}
	if ((from->can_id & CAN_RTR_FLAG) != 0) {
		frame->flags |= CAN_HOST_REMOTE;
	}
	if (size == CANFD_MTU) {
		frame->flags |= CAN_HOST_FD;
		frame->flags |= (from->flags & CANFD_BRS) != 0 ? CAN_HOST_BRS : 0;
		frame->flags |= (from->flags & CANFD_ESI) != 0 ? CAN_HOST_ESI : 0;
	}
	frame->id =
		from->can_id & ((from->can_id & CAN_EFF_FLAG) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK);
	frame->length = from->len;
	memcpy(frame->data, from->data, from->len);
	can_bus_received(bus, &event);
}

static bool read_some(struct loop_source *source)
{
	struct socketcan *socketcan = source->owner;
	struct iovec parts[READ_BATCH];
	int n;

	if (socketcan->bus->paused) {
		return false;
	}
	for (size_t i = 0; i < READ_BATCH; i++) {
		parts[i] = (struct iovec){&frames[i], sizeof(frames[i])};
		messages[i].msg_hdr = (struct msghdr){.msg_iov = &parts[i], .msg_iovlen = 1};
	}
	n = recvmmsg(socketcan->fd, messages, READ_BATCH, MSG_DONTWAIT, NULL);
	if (n < 0) {
		if (errno != EAGAIN && errno != EINTR) {
			fail(socketcan, "receive", errno);
		}
		return false;
	}
	for (int i = 0; i < n; i++) {
		take(socketcan->bus, &frames[i], messages[i].msg_len);
	}
	loop_hot(source);
	can_bus_received_all(socketcan->bus);
	return true;
}

static void on_readable(struct loop_source *source, uint32_t events)
{
	(void)events;
	read_some(source);
}

static void pause_reading(struct can_bus *bus, bool paused)
{
	struct socketcan *socketcan = bus->state;

	loop_want(&socketcan->source, paused ? 0 : EPOLLIN);
}

/* --- sending --------------------------------------------------------------------------------- */

static void on_busy_timer(struct loop_timer *timer)
{
	struct socketcan *socketcan = timer->owner;

	can_bus_ready(socketcan->bus);
}

static enum can_host_result send_frame(struct can_bus *bus, const struct can_host_frame *frame)
{
	struct socketcan *socketcan = bus->state;
	const bool fd = (frame->flags & CAN_HOST_FD) != 0;
	struct canfd_frame out = {.can_id = frame->id, .len = frame->length};
	ssize_t n;

	if (socketcan->fd <= 0) {
		return CAN_HOST_NOBODY;
	}
	if (fd && !socketcan->has_fd_frames) {
		return CAN_HOST_DESTROYED;
	}
	out.can_id |= (frame->flags & CAN_HOST_EXTENDED) != 0 ? CAN_EFF_FLAG : 0;
	out.can_id |= (frame->flags & CAN_HOST_REMOTE) != 0 ? CAN_RTR_FLAG : 0;
	out.flags = (frame->flags & CAN_HOST_BRS) != 0 ? CANFD_BRS : 0;
	memcpy(out.data, frame->data, frame->length);
	do {
		n = write(socketcan->fd, &out, fd ? CANFD_MTU : CAN_MTU);
	} while (n < 0 && errno == EINTR);
	if (n >= 0) {
		return CAN_HOST_SENT;
	}
	if (errno == ENOBUFS || errno == EAGAIN) {
		loop_timer_start(&socketcan->busy, BUSY_RETRY_MS);
		return CAN_HOST_BUSY;
	}
	fail(socketcan, "send", errno);
	return CAN_HOST_NOBODY;
}

/* --- opening --------------------------------------------------------------------------------- */

/* 0 or an errno. */
static int bind_to(struct socketcan *socketcan, int fd)
{
	struct sockaddr_can address = {.can_family = AF_CAN};
	struct ifreq request = {0};
	const can_err_mask_t errors = CAN_ERR_MASK;
	const int buffer = SOCKET_BUFFER;

	strcpy(request.ifr_name, socketcan->interface);
	if (ioctl(fd, SIOCGIFINDEX, &request) != 0) {
		return errno;
	}
	address.can_ifindex = request.ifr_ifindex;
	if (ioctl(fd, SIOCGIFFLAGS, &request) != 0) {
		return errno;
	}
	if ((request.ifr_flags & IFF_UP) == 0) {
		return ENETDOWN;
	}
	socketcan->has_fd_frames =
		ioctl(fd, SIOCGIFMTU, &request) == 0 && request.ifr_mtu >= (int)CANFD_MTU &&
		setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &(int){1}, sizeof(int)) == 0;
	setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof(buffer));
	if (setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof(errors)) != 0 ||
	    bind(fd, (const struct sockaddr *)&address, sizeof(address)) != 0) {
		return errno;
	}
	return 0;
}

static void start(struct can_bus *bus)
{
	struct socketcan *socketcan = bus->state;
	const int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
	int error;

	socketcan->busy.fire = on_busy_timer;
	socketcan->busy.owner = socketcan;
	if (fd < 0) {
		fail(socketcan, "the system has no CAN", errno);
		return;
	}
	error = bind_to(socketcan, fd);
	if (error != 0) {
		close(fd);
		fail(socketcan, "open", error);
		return;
	}
	socketcan->fd = fd;
	socketcan->drops_before = bus->kept.counts.rx_drops;
	socketcan->source.fd = fd;
	socketcan->source.ready = on_readable;
	socketcan->source.again = read_some;
	socketcan->source.owner = socketcan;
	loop_add(&socketcan->source, bus->paused ? 0 : EPOLLIN);
	can_bus_works(bus);
}

static void stop(struct can_bus *bus)
{
	close_socket(bus->state);
}

const struct can_bus_type can_bus_socketcan = {
	.scheme = "socketcan",
	.is_real = true,
	.state_size = sizeof(struct socketcan),
	.parse = parse,
	.start = start,
	.stop = stop,
	.send = send_frame,
	.pause = pause_reading,
	.count = count_drops,
};
