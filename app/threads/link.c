/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/link.h"

#include <zephyr/sys/atomic.h>

static atomic_t opaque;

void link_set_opaque(bool value)
{
	atomic_set(&opaque, value);
}

bool link_is_opaque(void)
{
	return atomic_get(&opaque) != 0;
}
