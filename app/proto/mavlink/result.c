/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

struct device_who mavlink_who(const struct mavlink_context *context)
{
	return (struct device_who){
		.way = context->is_signed ? SECURITY_WAY_MAVLINK_SIGNED : SECURITY_WAY_MAVLINK,
		.link = context->link,
	};
}

uint8_t mavlink_result(enum device_result result)
{
	switch (result) {
	case DEVICE_ACCEPTED:
		return MAV_RESULT_ACCEPTED;
	case DEVICE_DENIED:
	case DEVICE_EXCLUDED:
		return MAV_RESULT_DENIED;
	case DEVICE_OUTRANKED:
	case DEVICE_KEPT:
		return MAV_RESULT_TEMPORARILY_REJECTED;
	case DEVICE_FAILED:
	case DEVICE_ABSENT:
		break;
	}
	return MAV_RESULT_FAILED;
}
