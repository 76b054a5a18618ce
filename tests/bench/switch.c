/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a context switch costs: two threads hand a semaphore to and fro. Prints nanoseconds per
 * switch, with the give, the take and the scheduler's decision in it.
 */
#include <stdio.h>
#include <time.h>

#include <zephyr/kernel.h>

#include "kernel/port.h"

#define ROUNDS 2000000

static K_SEM_DEFINE(ping, 0, 1);
static K_SEM_DEFINE(pong, 0, 1);

static void answer(void *p1, void *p2, void *p3)
{
	for (int i = 0; i < ROUNDS; i++) {
		(void)k_sem_take(&ping, K_FOREVER);
		k_sem_give(&pong);
	}
}

K_THREAD_DEFINE(answerer, 1024, answer, NULL, NULL, NULL, 0, 0, 0);

static double host_now_ns(void)
{
	struct timespec now;

	(void)clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

int main(void)
{
	const double begin_ns = host_now_ns();

	for (int i = 0; i < ROUNDS; i++) {
		k_sem_give(&ping);
		(void)k_sem_take(&pong, K_FOREVER);
	}
	printf("%.1f ns per context switch\n", (host_now_ns() - begin_ns) / (2.0 * ROUNDS));
	(void)fflush(stdout);
	port_exit(0);
}
