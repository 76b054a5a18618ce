/* SPDX-License-Identifier: Apache-2.0 */
#include "host/loop.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/crash.h"
#include "host/module.h"

enum {
	EVENTS_MAX = 16,
	HOT_MAX = 64,    /* hot reads before the others get their turn */
	SPIN_NS = 50000, /* a wait that was shorter had better been spun */
};

static int epoll_fd = -1;
static struct loop_source *always_list;
static struct loop_timer *timers;
static struct loop_source *hot;
static unsigned int hot_count;
static bool can_spin;
static bool spins; /* the last wait for a hot source was short */
static unsigned int source_count;

/* The batch being served, so that a source that is removed meanwhile is not called any more. */
static struct epoll_event batch[EVENTS_MAX];
static int batch_count;

static int signal_pipe[2] = {-1, -1};
static volatile sig_atomic_t interrupted;

bool loop_interrupted(void)
{
	return interrupted != 0;
}

unsigned int loop_sources(void)
{
	return source_count;
}

static void fail(const char *what)
{
	fprintf(stderr, "pharos: %s: %s\n", what, strerror(errno));
	abort();
}

void loop_add(struct loop_source *source, uint32_t events)
{
	struct epoll_event event = {.events = events, .data.ptr = source};

	source->wanted = events;
	source->always = false;
	if (epoll_ctl(epoll_fd, EPOLL_CTL_ADD, source->fd, &event) != 0) {
		if (errno != EPERM) {
			fail("epoll");
		}
		source->always = true;
		source->next = always_list;
		always_list = source;
	}
	source->added = true;
	source_count++;
}

void loop_want(struct loop_source *source, uint32_t events)
{
	struct epoll_event event = {.events = events, .data.ptr = source};

	if (!source->added || source->wanted == events) {
		return;
	}
	source->wanted = events;
	if (!source->always && epoll_ctl(epoll_fd, EPOLL_CTL_MOD, source->fd, &event) != 0) {
		fail("epoll");
	}
}

void loop_remove(struct loop_source *source)
{
	if (!source->added) {
		return;
	}
	source->added = false;
	source_count--;
	if (hot == source) {
		hot = NULL;
	}
	for (int i = 0; i < batch_count; i++) {
		if (batch[i].data.ptr == source) {
			batch[i].data.ptr = NULL;
		}
	}
	if (!source->always) {
		epoll_ctl(epoll_fd, EPOLL_CTL_DEL, source->fd, NULL);
		return;
	}
	for (struct loop_source **at = &always_list; *at != NULL; at = &(*at)->next) {
		if (*at == source) {
			*at = source->next;
			return;
		}
	}
}

void loop_hot(struct loop_source *source)
{
	hot = source;
}

void loop_timer_stop(struct loop_timer *timer)
{
	if (!timer->running) {
		return;
	}
	timer->running = false;
	for (struct loop_timer **at = &timers; *at != NULL; at = &(*at)->next) {
		if (*at == timer) {
			*at = timer->next;
			return;
		}
	}
}

void loop_timer_start(struct loop_timer *timer, uint32_t delay_ms)
{
	loop_timer_stop(timer);
	timer->due_ns = clock_host_ns() + delay_ms * 1000000ull;
	timer->running = true;
	timer->next = timers;
	timers = timer;
}

static int run_timers(uint64_t now_ns)
{
	int count = 0;

	for (struct loop_timer *timer = timers; timer != NULL;) {
		if (timer->due_ns <= now_ns) {
			loop_timer_stop(timer);
			timer->fire(timer);
			count++;
			timer = timers; /* the list may have changed */
		} else {
			timer = timer->next;
		}
	}
	return count;
}

/* timeout_ns, shortened to the next timer. */
static int64_t bound_timeout(int64_t timeout_ns)
{
	uint64_t now_ns;

	if (timers == NULL || timeout_ns == 0) {
		return timeout_ns;
	}
	now_ns = clock_host_ns();
	for (struct loop_timer *timer = timers; timer != NULL; timer = timer->next) {
		const int64_t left = timer->due_ns > now_ns ? (int64_t)(timer->due_ns - now_ns) : 0;

		if (timeout_ns < 0 || left < timeout_ns) {
			timeout_ns = left;
		}
	}
	return timeout_ns;
}

static int wait_events(int64_t timeout_ns)
{
	static bool no_nanoseconds;
	int timeout_ms;

	if (timeout_ns > 0 && !no_nanoseconds) {
		const struct timespec timeout = {timeout_ns / 1000000000, timeout_ns % 1000000000};
		const int n = epoll_pwait2(epoll_fd, batch, EVENTS_MAX, &timeout, NULL);

		if (n >= 0 || errno != ENOSYS) {
			return n;
		}
		no_nanoseconds = true; /* Linux before 5.11 */
	}
	timeout_ms = timeout_ns < 0 ? -1 : (int)((timeout_ns + 999999) / 1000000);
	return epoll_wait(epoll_fd, batch, EVENTS_MAX, timeout_ms);
}

static int serve_always(void)
{
	int count = 0;

	for (struct loop_source *source = always_list; source != NULL;) {
		struct loop_source *next = source->next;

		if ((source->wanted & (EPOLLIN | EPOLLOUT)) != 0) {
			source->ready(source, source->wanted);
			count++;
		}
		source = next;
	}
	return count;
}

/* Waking up from epoll_wait() costs more than a datagram does. */
static bool spin(struct loop_source *source, int64_t timeout_ns)
{
	const uint64_t start_ns = clock_host_ns();
	const uint64_t limit_ns =
		timeout_ns < 0 || timeout_ns > SPIN_NS ? SPIN_NS : (uint64_t)timeout_ns;

	do {
		if (source->again(source)) {
			return true;
		}
	} while (!loop_interrupted() && clock_host_ns() - start_ns < limit_ns);
	spins = false;
	return false;
}

static bool serve_hot(int64_t timeout_ns)
{
	struct loop_source *source = hot;

	if (source == NULL || hot_count >= HOT_MAX) {
		hot_count = 0;
		return false;
	}
	hot_count++;
	if (source->again(source) || (spins && timeout_ns != 0 && spin(source, timeout_ns))) {
		return true;
	}
	hot_count = 0;
	hot = NULL;
	return false;
}

static int serve_events(void)
{
	int count = 0;

	for (int i = 0; i < batch_count; i++) {
		struct loop_source *source = batch[i].data.ptr;

		if (source != NULL) {
			count++;
			source->ready(source, batch[i].events);
		}
	}
	batch_count = 0;
	return count;
}

int loop_poll(int64_t timeout_ns)
{
	const bool may_spin = timeout_ns != 0 && can_spin && hot != NULL;
	uint64_t start_ns;
	int served;

	if (serve_hot(bound_timeout(timeout_ns))) {
		return 1;
	}
	served = serve_always();
	start_ns = may_spin ? clock_host_ns() : 0;
	/* A source that is still hot has had its HOT_MAX turns: the others only get a look. */
	batch_count = wait_events(served > 0 || hot != NULL ? 0 : bound_timeout(timeout_ns));
	if (batch_count < 0) {
		batch_count = 0;
		if (errno != EINTR) {
			fail("epoll_wait");
		}
	}
	if (may_spin && batch_count > 0 && clock_host_ns() - start_ns < SPIN_NS) {
		spins = true;
	}
	served += serve_events();
	if (timers != NULL) {
		served += run_timers(clock_host_ns());
	}
	return served;
}

static void on_signal(int number)
{
	const int error = errno;

	if (interrupted != 0) {
		/* The second one: the device hangs in a loop and never goes idle. */
		crash_restore();
		_exit(128 + number);
	}
	interrupted = 1;
	if (write(signal_pipe[1], "", 1) < 0) {
		/* A full pipe wakes the loop as well. */
	}
	errno = error;
}

static void on_signal_pipe(struct loop_source *source, uint32_t events)
{
	char bytes[16];

	(void)events;
	while (read(source->fd, bytes, sizeof(bytes)) > 0) {
	}
}

static struct loop_source signal_source = {.fd = -1, .ready = on_signal_pipe};

static int start(void)
{
	struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART | SA_ONSTACK};

	epoll_fd = epoll_create1(EPOLL_CLOEXEC);
	if (epoll_fd < 0 || pipe2(signal_pipe, O_CLOEXEC | O_NONBLOCK) != 0) {
		fprintf(stderr, "pharos: event loop: %s\n", strerror(errno));
		return -1;
	}
	signal_source.fd = signal_pipe[0];
	loop_add(&signal_source, EPOLLIN);
	source_count = 0;
	sigaction(SIGINT, &action, NULL);
	sigaction(SIGTERM, &action, NULL);
	signal(SIGPIPE, SIG_IGN);
	can_spin = !clock_is_virtual() && sysconf(_SC_NPROCESSORS_ONLN) > 1;
	/* Strobe edges in real time: the default slack of 50 us would be visible. */
	prctl(PR_SET_TIMERSLACK, 1ul);
	return 0;
}

static void stop(void)
{
	loop_remove(&signal_source);
	close(signal_pipe[0]);
	close(signal_pipe[1]);
	close(epoll_fd);
	epoll_fd = -1;
}

HOST_MODULE(loop_module) = {
	.name = "loop",
	.order = HOST_ORDER_BASE - 1,
	.start = start,
	.stop = stop,
};
