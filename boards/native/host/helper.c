/* SPDX-License-Identifier: Apache-2.0 */
#include "host/helper.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/loop.h"

/* One lock for all: it is held for a few instructions at a time. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct helper_job *done_first;

static void on_done(struct loop_source *source, uint32_t events);

static struct loop_source done_source = {.fd = -1, .ready = on_done};

static void append(struct helper_job **list, struct helper_job *job)
{
	while (*list != NULL) {
		list = &(*list)->next;
	}
	job->next = NULL;
	*list = job;
}

static struct helper_job *take(struct helper_job **list)
{
	struct helper_job *job = *list;

	if (job != NULL) {
		*list = job->next;
	}
	return job;
}

static void on_done(struct loop_source *source, uint32_t events)
{
	uint64_t count;
	struct helper_job *job;

	(void)events;
	if (read(source->fd, &count, sizeof(count)) < 0) {
		return;
	}
	do {
		pthread_mutex_lock(&lock);
		job = take(&done_first);
		pthread_mutex_unlock(&lock);
		if (job != NULL) {
			job->done(job);
		}
	} while (job != NULL);
}

static void tell_done(struct helper_job *job)
{
	const uint64_t one = 1;

	append(&done_first, job);
	while (write(done_source.fd, &one, sizeof(one)) < 0 && errno == EINTR) {
	}
}

static void *run(void *arg)
{
	struct helper *helper = arg;

	pthread_mutex_lock(&lock);
	for (;;) {
		struct helper_job *job = take(&helper->first);

		helper->is_busy = job != NULL;
		if (job == NULL) {
			pthread_cond_broadcast(&helper->changed);
			pthread_cond_wait(&helper->changed, &lock);
			continue;
		}
		pthread_mutex_unlock(&lock);
		job->work(job);
		pthread_mutex_lock(&lock);
		if (job->done != NULL) {
			tell_done(job);
		}
	}
	return NULL;
}

/* With all signals blocked: they are the board's, and a terminal in the background is written to
 * all the same. */
static bool start_thread(struct helper *helper)
{
	pthread_condattr_t monotonic;
	sigset_t all;
	sigset_t before;
	int error;

	pthread_condattr_init(&monotonic);
	pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
	pthread_cond_init(&helper->changed, &monotonic);
	pthread_condattr_destroy(&monotonic);
	sigfillset(&all);
	pthread_sigmask(SIG_SETMASK, &all, &before);
	error = pthread_create(&helper->thread, NULL, run, helper);
	pthread_sigmask(SIG_SETMASK, &before, NULL);
	if (error != 0) {
		return false;
	}
	pthread_setname_np(helper->thread, helper->name);
	return true;
}

static bool start(struct helper *helper)
{
	if (clock_is_virtual()) {
		return false;
	}
	if (done_source.fd < 0) {
		done_source.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
		if (done_source.fd < 0) {
			return false;
		}
		loop_add(&done_source, EPOLLIN);
	}
	helper->is_started = start_thread(helper);
	return helper->is_started;
}

void helper_submit(struct helper *helper, struct helper_job *job)
{
	if (!helper->is_started && !start(helper)) {
		job->work(job);
		if (job->done != NULL) {
			job->done(job);
		}
		return;
	}
	pthread_mutex_lock(&lock);
	append(&helper->first, job);
	pthread_cond_broadcast(&helper->changed);
	pthread_mutex_unlock(&lock);
}

bool helper_finish(struct helper *helper, unsigned int timeout_ms)
{
	struct timespec until;
	bool is_done;
	int error = 0;

	if (!helper->is_started) {
		return true;
	}
	clock_gettime(CLOCK_MONOTONIC, &until);
	until.tv_sec += (time_t)(timeout_ms / 1000u);
	until.tv_nsec += (long)(timeout_ms % 1000u) * 1000000;
	until.tv_sec += until.tv_nsec / 1000000000;
	until.tv_nsec %= 1000000000;
	pthread_mutex_lock(&lock);
	while ((helper->first != NULL || helper->is_busy) && error == 0) {
		error = pthread_cond_timedwait(&helper->changed, &lock, &until);
	}
	is_done = helper->first == NULL && !helper->is_busy;
	pthread_mutex_unlock(&lock);
	return is_done;
}
