/* SPDX-License-Identifier: Apache-2.0 */
#include "models/lines.h"

uint32_t lines_levels(const struct lines *self)
{
	const uint32_t free = ~self->output & ~self->driven;

	return (self->output & self->output_level) |
	       (~self->output & self->driven & self->driven_level) | (free & self->pull_up);
}

void lines_reset(struct lines *self)
{
	self->output = 0;
	self->output_level = 0;
	self->pull_up = 0;
}
