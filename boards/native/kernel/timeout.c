/* SPDX-License-Identifier: Apache-2.0 */
#include "port.h"
#include "sched.h"

/* By tick, then in the order of their start. */
static sys_dlist_t timeouts = SYS_DLIST_STATIC_INIT(&timeouts);
static bool announcing;
static uint64_t announced_tick; /* while announcing */

static uint64_t us_to_ticks(uint64_t us)
{
	return native_time_convert(us, USEC_PER_SEC, CONFIG_SYS_CLOCK_TICKS_PER_SEC,
	                           NATIVE_ROUND_FLOOR);
}

static uint64_t now_tick(void)
{
	return announcing ? announced_tick : us_to_ticks(port_clock_now_us());
}

static struct _timeout *first_timeout(void)
{
	return SYS_DLIST_CONTAINER(sys_dlist_peek_head(&timeouts), (struct _timeout *)NULL, node);
}

/*
 * now lies somewhere inside its tick, so n whole ticks have certainly passed only at the tick after
 * now + n. Sums saturate: a timeout that long never ends.
 */
static uint64_t end_tick(k_timeout_t when)
{
	const uint64_t now = now_tick();

	if (when.ticks < K_TICKS_FOREVER) {
		return MAX((uint64_t)Z_TICK_ABS(when.ticks), now + 1);
	}
	return MIN((uint64_t)when.ticks, UINT64_MAX / 2 - now) + 1 + now;
}

void timeout_add(struct _timeout *timeout, _timeout_func_t fn, k_timeout_t when)
{
	if (K_TIMEOUT_EQ(when, K_FOREVER)) {
		return;
	}
	__ASSERT(!timeout_active(timeout), "timeout runs already");
	timeout->fn = fn;
	timeout->tick = end_tick(when);

	sys_dnode_t *node = sys_dlist_peek_head(&timeouts);

	while (node != NULL && CONTAINER_OF(node, struct _timeout, node)->tick <= timeout->tick) {
		node = sys_dlist_peek_next(&timeouts, node);
	}
	sys_dlist_insert(node != NULL ? node : &timeouts, &timeout->node);
}

bool timeout_abort(struct _timeout *timeout)
{
	if (!timeout_active(timeout)) {
		return false;
	}
	sys_dlist_remove(&timeout->node);
	return true;
}

uint64_t timeout_next_us(void)
{
	const struct _timeout *first = first_timeout();

	if (first == NULL ||
	    first->tick / CONFIG_SYS_CLOCK_TICKS_PER_SEC >= UINT64_MAX / USEC_PER_SEC) {
		return UINT64_MAX;
	}
	return native_time_convert(first->tick, CONFIG_SYS_CLOCK_TICKS_PER_SEC, USEC_PER_SEC,
	                           NATIVE_ROUND_CEIL);
}

void timeout_announce(void)
{
	const uint64_t now = us_to_ticks(port_clock_now_us());
	struct _timeout *first = first_timeout();

	if (announcing) {
		return;
	}
	while (first != NULL && first->tick <= now) {
		announcing = true;
		announced_tick = first->tick;
		sys_dlist_remove(&first->node);
		first->fn(first);
		first = first_timeout();
	}
	announcing = false;
}

k_ticks_t timeout_expires(const struct _timeout *timeout)
{
	return timeout_active(timeout) ? (k_ticks_t)timeout->tick : (k_ticks_t)now_tick();
}

k_ticks_t timeout_remaining(const struct _timeout *timeout)
{
	return timeout_expires(timeout) - (k_ticks_t)now_tick();
}

int64_t sys_clock_tick_get(void)
{
	return (int64_t)now_tick();
}

uint64_t k_cycle_get_64(void)
{
	return port_cycles();
}

/* With interrupts off the expiries are late: they run when interrupts are on again. */
void k_busy_wait(uint32_t usec_to_wait)
{
	const uint64_t until_us = port_clock_now_us() + usec_to_wait;

	while (port_clock_now_us() < until_us) {
		const uint64_t next_us = timeout_next_us();

		if (native_cpu.irq_locked || native_cpu.isr_depth > 0) {
			port_clock_busy_wait(until_us);
			native_cpu.irq_waiting = true;
			return;
		}
		if (next_us <= until_us) {
			port_clock_busy_wait(next_us);
			irq_enter();
			timeout_announce();
			irq_exit();
		} else {
			port_clock_busy_wait(until_us);
		}
	}
}
