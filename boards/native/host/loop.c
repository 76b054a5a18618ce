/* SPDX-License-Identifier: Apache-2.0 */
#include "host/loop.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/crash.h"
#include "host/module.h"

enum {
	EVENTS_MAX = 16,
	ALARM_SLACK_NS = 1000, /* so little later is no reason to set the alarm anew */
	HOT_MAX = 64,          /* hot reads before the others get their turn */
};

static int epoll_fd = -1;
static struct loop_source *always_list;
static struct loop_timer *timers;
static struct loop_source *hot;
static unsigned int hot_count;
static uint64_t alarm_ns; /* host time that the alarm is set for; 0: not set */
static unsigned int source_count;

static void on_alarm(struct loop_source *source, uint32_t events);

static struct loop_source alarm_source = {.fd = -1, .ready = on_alarm};

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

static void on_alarm(struct loop_source *source, uint32_t events)
{
	uint64_t expirations;

	if (read(source->fd, &expirations, sizeof(expirations)) > 0) {
		alarm_ns = 0;
	}
}

/*
 * A time-out of epoll's own sets the processor's timer at every wait, which can cost more than all
 * else. An alarm that comes early does no harm, so it is set only for a time before the one it has.
 */
static void set_alarm(uint64_t due_ns)
{
	const struct itimerspec at = {
		.it_value = {(time_t)(due_ns / 1000000000u), (long)(due_ns % 1000000000u)},
	};

	if (alarm_ns != 0 && alarm_ns <= due_ns + ALARM_SLACK_NS) {
		return;
	}
	timerfd_settime(alarm_source.fd, TFD_TIMER_ABSTIME, &at, NULL);
	alarm_ns = due_ns;
}

static int wait_events(int64_t timeout_ns)
{
	uint64_t until_ns = UINT64_MAX;
	int count;

	if (timeout_ns == 0) {
		return epoll_wait(epoll_fd, batch, EVENTS_MAX, 0);
	}
	if (timeout_ns > 0) {
		until_ns = clock_host_ns() + (uint64_t)timeout_ns;
		set_alarm(until_ns);
	}
	clock_wait_begin(until_ns);
	count = epoll_wait(epoll_fd, batch, EVENTS_MAX, -1);
	clock_wait_end();
	return count;
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

static bool serve_hot(void)
{
	if (hot == NULL || hot_count >= HOT_MAX) {
		hot_count = 0;
		return false;
	}
	struct loop_source *const source = hot;

	hot = NULL; /* unless it says so again */
	hot_count++;
	return source->again(source);
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
	int served;

	if (serve_hot()) {
		return 1;
	}
	served = serve_always();
	/* A source that is still hot has had its HOT_MAX turns: the others only get a look. */
	batch_count = wait_events(served > 0 || hot != NULL ? 0 : bound_timeout(timeout_ns));
	if (batch_count < 0) {
		batch_count = 0;
		if (errno != EINTR) {
			fail("epoll_wait");
		}
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
	alarm_source.fd = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
	if (epoll_fd < 0 || alarm_source.fd < 0 ||
	    pipe2(signal_pipe, O_CLOEXEC | O_NONBLOCK) != 0) {
		fprintf(stderr, "pharos: event loop: %s\n", strerror(errno));
		return -1;
	}
	signal_source.fd = signal_pipe[0];
	loop_add(&signal_source, EPOLLIN);
	loop_add(&alarm_source, EPOLLIN);
	source_count = 0;
	sigaction(SIGINT, &action, NULL);
	sigaction(SIGTERM, &action, NULL);
	/* A write says so itself: its reader has gone, or the file is as large as it may be. */
	signal(SIGPIPE, SIG_IGN);
	signal(SIGXFSZ, SIG_IGN);
	/* Strobe edges in real time: the default slack of 50 us would be visible. */
	prctl(PR_SET_TIMERSLACK, 1ul);
	return 0;
}

static void stop(void)
{
	loop_remove(&alarm_source);
	close(alarm_source.fd);
	loop_remove(&signal_source);
	close(signal_pipe[0]);
	close(signal_pipe[1]);
	close(epoll_fd);
	epoll_fd = -1;
}

HOST_MODULE(loop_module) = {
	.name = "loop",
	.order = HOST_ORDER_BASE - 1,
	.drives = true,
	.start = start,
	.stop = stop,
};
