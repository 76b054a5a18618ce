/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The table behind params.h, a macro per group. A parameter's index is its place; new ones go to
 * the end of their group. Rows:
 *
 * X(name, group, unit, decimals, min, max, default, flags, meaning)
 *
 * min, max and default are the core's integers: decimals 3 makes 80500 of 80.5 of the unit. A range
 * ends where a binary32 no longer tells one step from the next: 16 s in us.
 */
#ifndef PHAROS_CORE_PARAMS_TABLE_H
#define PHAROS_CORE_PARAMS_TABLE_H

/* The light itself. */
#define PARAMS_LIGHT(X)                                                                            \
	X(LGT_CURVE, LIGHT, "", 0, 0, 1, CONFIG_PHAROS_LIGHT_CURVE, 0,                             \
	  "Brightness to light: 0 linear, 1 perceptual (CIE 1931)")                                \
	X(LGT_RESTORE, LIGHT, "", 0, 0, 1, CONFIG_PHAROS_LIGHT_RESTORE, PARAM_FLAG_REBOOT,         \
	  "After a reset: 0 off, 1 as it was last commanded")                                      \
	X(STRB_MIN, LIGHT, "s", 6, 1000, 16000000, CONFIG_PHAROS_STROBE_PERIOD_MIN_US, 0,          \
	  "Shortest strobe period")                                                                \
	X(STRB_MAX, LIGHT, "s", 6, 1000, 16000000, CONFIG_PHAROS_STROBE_PERIOD_MAX_US, 0,          \
	  "Longest strobe period")                                                                 \
	X(BCN_PERIOD, LIGHT, "s", 6, 1000, 16000000, CONFIG_PHAROS_BEACON_PERIOD_US, 0,            \
	  "Beacon: period, brought between STRB_MIN and STRB_MAX")                                 \
	X(BCN_DUTY, LIGHT, "%", 4, 1, 1000000, CONFIG_PHAROS_BEACON_DUTY_PPM, 0,                   \
	  "Beacon: lit part of the period; all of it is steady")                                   \
	X(BCN_BRIGHT, LIGHT, "%", 4, 0, 1000000, CONFIG_PHAROS_BEACON_BRIGHTNESS_PPM, 0,           \
	  "Beacon: brightness")                                                                    \
	X(LGT_PROGRAM, LIGHT, "", 0, 0, 4, CONFIG_PHAROS_LIGHT_PROGRAM, 0,                         \
	  "While on without a strobe: 0 steady, 1 anti-collision, 2 double flash, 3 fade, 4 SOS")  \
	X(PRG_RATE, LIGHT, "1/min", 0, 40, 100, CONFIG_PHAROS_PROGRAM_RATE, 0,                     \
	  "Programs 1 and 2: flashes, or pairs of them, a minute")                                 \
	X(PRG_FLASH, LIGHT, "s", 3, 10, 190, CONFIG_PHAROS_PROGRAM_FLASH_MS, 0,                    \
	  "Programs 1 and 2: length of a flash")                                                   \
	X(PRG_FADE, LIGHT, "s", 3, 500, 60000, CONFIG_PHAROS_PROGRAM_FADE_MS, 0,                   \
	  "Program 3: time up and down")                                                           \
	X(PRG_DOT, LIGHT, "s", 3, 50, 1000, CONFIG_PHAROS_PROGRAM_DOT_MS, 0,                       \
	  "Program 4: length of a dot")

/* Who commands, and what holds when nobody does. */
#define PARAMS_ARBITER(X)                                                                          \
	X(LGT_FALLBACK, ARBITER, "", 0, 0, 2, CONFIG_PHAROS_LIGHT_FALLBACK, 0,                     \
	  "When every commander is silent: 0 keep, 1 off, 2 beacon")                               \
	X(LGT_LOSS, ARBITER, "s", 3, 0, 3600000, CONFIG_PHAROS_LIGHT_LOSS_MS, 0,                   \
	  "Silence after which the fallback applies, 0 never")                                     \
	X(LGT_SRC_PRIO, ARBITER, "", 0, 0, 4, CONFIG_PHAROS_SOURCE_PRIORITY, 0,                    \
	  "Source that outranks the others: 0 none, 1 MAVLink, 2 DroneCAN, 3 IMC, 4 shell")        \
	X(LGT_SRC_HOLD, ARBITER, "s", 3, 0, 3600000, CONFIG_PHAROS_SOURCE_HOLD_MS, 0,              \
	  "How long after its last command that source outranks the others")                       \
	X(LGT_SRC_EXCL, ARBITER, "", 0, 0, 15, CONFIG_PHAROS_SOURCE_EXCLUDE, 0,                    \
	  "Sources that may not command: sum of 1 MAVLink, 2 DroneCAN, 4 IMC, 8 shell")            \
	X(LGT_SRC_NOW, ARBITER, "", 0, 0, 5, 0, PARAM_FLAG_READ_ONLY,                              \
	  "Source in command: as LGT_SRC_PRIO, 5 the fallback")

/* Heat. */
#define PARAMS_THERMAL(X)                                                                          \
	X(THR_THROTTLE, THERMAL, "degC", 3, -40000, 150000, CONFIG_PHAROS_THERMAL_THROTTLE_MDEGC,  \
	  0, "Derating begins here")                                                               \
	X(THR_SHUTDOWN, THERMAL, "degC", 3, -40000, 150000, CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC,  \
	  0, "The lamp goes off here")                                                             \
	X(THR_RECOVER, THERMAL, "degC", 3, -40000, 150000, CONFIG_PHAROS_THERMAL_RECOVER_MDEGC, 0, \
	  "Below this a shutdown ends")                                                            \
	X(THR_HYST, THERMAL, "degC", 3, 0, 50000, CONFIG_PHAROS_THERMAL_HYSTERESIS_MDEGC, 0,       \
	  "Throttling ends this far below its begin")                                              \
	X(THR_FLOOR, THERMAL, "%", 4, 0, 1000000, CONFIG_PHAROS_THERMAL_FLOOR_PPM, 0,              \
	  "Limit that derating reaches just below shutdown")                                       \
	X(THR_SAFE, THERMAL, "%", 4, 0, 1000000, CONFIG_PHAROS_THERMAL_SAFE_PPM, 0,                \
	  "Limit while the sensor has failed")                                                     \
	X(THR_SLEW, THERMAL, "%/s", 4, 1, 10000000, CONFIG_PHAROS_THERMAL_SLEW_PPM_PER_S, 0,       \
	  "Fastest rise of the limit")                                                             \
	X(THR_SENS_MIN, THERMAL, "degC", 3, -273150, 1000000,                                      \
	  CONFIG_PHAROS_THERMAL_SENSOR_MIN_MDEGC, 0, "Colder than this is not plausible")          \
	X(THR_SENS_MAX, THERMAL, "degC", 3, -273150, 1000000,                                      \
	  CONFIG_PHAROS_THERMAL_SENSOR_MAX_MDEGC, 0, "Hotter than this is not plausible")          \
	X(THR_RATE, THERMAL, "degC/s", 3, 1, 10000000,                                             \
	  CONFIG_PHAROS_THERMAL_SENSOR_RATE_MDEGC_PER_S, 0, "Faster changes are not plausible")    \
	X(THR_NOISE, THERMAL, "degC", 3, 0, 100000, CONFIG_PHAROS_THERMAL_SENSOR_NOISE_MDEGC, 0,   \
	  "Noise allowed beyond that rate")                                                        \
	X(THR_STUCK, THERMAL, "s", 3, 100, 3600000, CONFIG_PHAROS_THERMAL_SENSOR_STUCK_MS, 0,      \
	  "A lit lamp's sensor may stand still so long")                                           \
	X(THR_MISS, THERMAL, "s", 3, 100, 60000, CONFIG_PHAROS_THERMAL_SENSOR_MISSING_MS, 0,       \
	  "Samples may stay away so long")                                                         \
	X(THR_GOOD_N, THERMAL, "", 0, 1, 1000, CONFIG_PHAROS_THERMAL_SENSOR_GOOD_SAMPLES, 0,       \
	  "Good samples in a row that heal a sensor")                                              \
	X(THR_HOT, THERMAL, "%", 4, 0, 1000000, CONFIG_PHAROS_THERMAL_HOT_PPM, 0,                  \
	  "Limit while a failed sensor says heat, at most THR_SAFE; 0 shuts down")                 \
	X(THR_FIRST, THERMAL, "s", 3, 0, 3600000, CONFIG_PHAROS_THERMAL_FIRST_MS, 0,               \
	  "Without a first sample THR_SAFE is allowed after this, 0 never")

/* External sync. */
#define PARAMS_SYNC(X)                                                                             \
	X(SYNC_MODE, SYNC, "", 0, 0, 1, CONFIG_PHAROS_SYNC_MODE, 0,                                \
	  "External sync: 0 the gate follows the input, 1 each edge gives a pulse")                \
	X(SYNC_POL, SYNC, "", 0, 0, 1, CONFIG_PHAROS_SYNC_POLARITY, 0,                             \
	  "Input is active: 0 high, 1 low")                                                        \
	X(SYNC_RETRIG, SYNC, "", 0, 0, 1, CONFIG_PHAROS_SYNC_RETRIGGER, 0,                         \
	  "An edge during a pulse: 0 is ignored, 1 prolongs it")                                   \
	X(SYNC_LOSS, SYNC, "", 0, 0, 2, CONFIG_PHAROS_SYNC_POLICY, 0,                              \
	  "When the input is silent: 0 off, 1 on, 2 internal strobe")                              \
	X(SYNC_TMO, SYNC, "s", 3, 0, 3600000, CONFIG_PHAROS_SYNC_TIMEOUT_MS, 0,                    \
	  "Silence of the input that counts as loss, 0 never")                                     \
	X(SYNC_FILT, SYNC, "us", 0, 0, 1000000, CONFIG_PHAROS_SYNC_FILTER_US, 0,                   \
	  "Shorter changes of the input are glitches")                                             \
	X(SYNC_PULSE, SYNC, "us", 0, 1, 16000000, CONFIG_PHAROS_SYNC_PULSE_US, 0,                  \
	  "Length of a pulse")

/* MAVLink. */
#define PARAMS_MAVLINK(X)                                                                          \
	X(MAV_SYSID, MAVLINK, "", 0, 0, 255, CONFIG_PHAROS_MAVLINK_SYSTEM_ID, PARAM_FLAG_REBOOT,   \
	  "MAVLink system id, 0 adopts the vehicle's")                                             \
	X(MAV_COMPID, MAVLINK, "", 0, 1, 255, CONFIG_PHAROS_MAVLINK_COMPONENT_ID,                  \
	  PARAM_FLAG_REBOOT, "MAVLink component id")

#ifdef CONFIG_PHAROS_SIGNING
#ifdef CONFIG_PHAROS_IMC
#define PARAMS_KEY_IMC(X)                                                                          \
	X(MAV_KEY_IMC, MAVLINK, "", 0, 0, 2, CONFIG_PHAROS_KEY_IMC, 0,                             \
	  "What IMC may do beside a key: 0 look, 1 lamp, gimbal and outputs, 2 all but lock and "  \
	  "key")
#else
#define PARAMS_KEY_IMC(X)
#endif
#define PARAMS_SIGNING(X)                                                                          \
	X(MAV_SECURE, MAVLINK, "", 0, 0, 255, CONFIG_PHAROS_SECURE_LINKS, 0,                       \
	  "Links that may set the key: sum of 1 for the first UART, 2, 4 …, tunnels last")         \
	X(MAV_KEY_CAN, MAVLINK, "", 0, 0, 2, CONFIG_PHAROS_KEY_CAN, 0,                             \
	  "What DroneCAN may do beside a key: 0 look, 1 lamp and gimbal, 2 all but lock and key")  \
	PARAMS_KEY_IMC(X)
#else
#define PARAMS_SIGNING(X)
#endif

#ifdef CONFIG_PHAROS_ROUTING
#define PARAMS_ROUTING(X)                                                                          \
	X(MAV_ROUTE, MAVLINK, "", 0, 0, 1, CONFIG_PHAROS_ROUTE, 0,                                 \
	  "Forward MAVLink between links: 0 no, 1 yes")
#else
#define PARAMS_ROUTING(X)
#endif

/* CAN and DroneCAN. */
#define PARAMS_DRONECAN(X)                                                                         \
	X(CAN_NODE_ID, DRONECAN, "", 0, 0, 125, CONFIG_PHAROS_CAN_NODE_ID, PARAM_FLAG_REBOOT,      \
	  "DroneCAN node id, 0 asks the allocator")                                                \
	X(CAN_FD, DRONECAN, "", 0, 0, 1, CONFIG_PHAROS_CAN_FD, PARAM_FLAG_REBOOT,                  \
	  "CAN FD: 0 no, 1 yes")                                                                   \
	X(CAN_BITRATE, DRONECAN, "bit/s", 0, 10000, 1000000, CONFIG_PHAROS_CAN_BITRATE,            \
	  PARAM_FLAG_REBOOT, "Bit rate of the CAN bus")                                            \
	X(CAN_LIGHT_ID, DRONECAN, "", 0, -1, 255, CONFIG_PHAROS_CAN_LIGHT_ID, 0,                   \
	  "Light id in LightsCommand that is ours, -1 none")                                       \
	X(CAN_HARDPT_ID, DRONECAN, "", 0, -1, 255, CONFIG_PHAROS_CAN_HARDPOINT_ID, 0,              \
	  "Hardpoint id that switches the light, -1 none")                                         \
	X(CAN_ACT_BRT, DRONECAN, "", 0, 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_BRIGHTNESS, 0,          \
	  "Actuator id of the brightness, 0 none")                                                 \
	X(CAN_ACT_PAN, DRONECAN, "", 0, 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_PAN, 0,                 \
	  "Actuator id of pan, 0 none")                                                            \
	X(CAN_ACT_TILT, DRONECAN, "", 0, 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_TILT, 0,               \
	  "Actuator id of tilt, 0 none")

/* IMC, and what the UARTs speak. */
#ifdef CONFIG_PHAROS_IMC
#define PARAMS_IMC(X)                                                                              \
	X(IMC_ID, IMC, "", 0, 0x8000, 0x8FFF, CONFIG_PHAROS_IMC_ID, PARAM_FLAG_REBOOT,             \
	  "IMC id: one of those of sensors")                                                       \
	X(IMC_ANNOUNCE, IMC, "", 0, 0, 2, CONFIG_PHAROS_IMC_ANNOUNCE, 0,                           \
	  "Announce over UDP: 0 on this host, 1 broadcast, 2 multicast 224.0.75.69")               \
	X(UART0_PROTO, IMC, "", 0, 0, 1, CONFIG_PHAROS_UART0_PROTOCOL, PARAM_FLAG_REBOOT,          \
	  "What the first UART speaks: 0 MAVLink, 1 IMC")                                          \
	X(UART1_PROTO, IMC, "", 0, 0, 1, CONFIG_PHAROS_UART1_PROTOCOL, PARAM_FLAG_REBOOT,          \
	  "The second")                                                                            \
	X(UART2_PROTO, IMC, "", 0, 0, 1, CONFIG_PHAROS_UART2_PROTOCOL, PARAM_FLAG_REBOOT,          \
	  "The third")                                                                             \
	X(UART3_PROTO, IMC, "", 0, 0, 1, CONFIG_PHAROS_UART3_PROTOCOL, PARAM_FLAG_REBOOT,          \
	  "The fourth")
#else
#define PARAMS_IMC(X)
#endif

/* What IMC actuates besides the lamp and the gimbal. */
#ifdef CONFIG_PHAROS_IMC
#define PARAMS_OUTPUTS(X)                                                                          \
	X(ESC_MIN, OUTPUTS, "us", 0, 500, 1400, CONFIG_PHAROS_ESC_MIN_US, 0,                       \
	  "Pulse of the thruster at full reverse")                                                 \
	X(ESC_MAX, OUTPUTS, "us", 0, 1600, 2500, CONFIG_PHAROS_ESC_MAX_US, 0,                      \
	  "Pulse of the thruster at full ahead")                                                   \
	X(ESC_ARM, OUTPUTS, "s", 3, 0, 60000, CONFIG_PHAROS_ESC_ARM_MS, 0,                         \
	  "Neutral so long before the thruster takes setpoints")                                   \
	X(ESC_LOSS, OUTPUTS, "s", 3, 50, 60000, CONFIG_PHAROS_ESC_LOSS_MS, 0,                      \
	  "Without a setpoint for so long the thruster is neutral")                                \
	X(ZOOM_TIME, OUTPUTS, "s", 3, 100, 600000, CONFIG_PHAROS_ZOOM_TIME_MS, PARAM_FLAG_REBOOT,  \
	  "What the beam's motor needs from flood to spot")                                        \
	X(DOWN_TIME, OUTPUTS, "s", 0, 0, 3600, CONFIG_PHAROS_DOWN_TIME_S, PARAM_FLAG_REBOOT,       \
	  "How long a power-down is announced before it happens")
#else
#define PARAMS_OUTPUTS(X)
#endif

/* The gimbal. */
#ifdef CONFIG_PHAROS_GIMBAL
#define PARAMS_GIMBAL(X)                                                                           \
	X(GMB_ENABLE, GIMBAL, "", 0, 0, 1, CONFIG_PHAROS_GIMBAL_ENABLE, PARAM_FLAG_REBOOT,         \
	  "Gimbal: 0 none, 1 pan and tilt servos")                                                 \
	X(GMB_COMPID, GIMBAL, "", 0, 1, 255, CONFIG_PHAROS_GIMBAL_COMPONENT_ID, PARAM_FLAG_REBOOT, \
	  "MAVLink component id of the gimbal")                                                    \
	X(GMB_PAN_MIN, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_PAN_MIN_MDEG, 0,    \
	  "Leftmost pan")                                                                          \
	X(GMB_PAN_MAX, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_PAN_MAX_MDEG, 0,    \
	  "Rightmost pan")                                                                         \
	X(GMB_PAN_RATE, GIMBAL, "deg/s", 3, 1000, 2000000,                                         \
	  CONFIG_PHAROS_GIMBAL_PAN_RATE_MDEG_PER_S, 0, "Fastest pan")                              \
	X(GMB_PAN_PW_MIN, GIMBAL, "us", 0, 500, 2500, CONFIG_PHAROS_GIMBAL_PAN_PULSE_MIN_US, 0,    \
	  "Pulse at GMB_PAN_MIN; longer than GMB_PAN_PW_MAX reverses the servo")                   \
	X(GMB_PAN_PW_MAX, GIMBAL, "us", 0, 500, 2500, CONFIG_PHAROS_GIMBAL_PAN_PULSE_MAX_US, 0,    \
	  "Pulse at GMB_PAN_MAX")                                                                  \
	X(GMB_PAN_TRIM, GIMBAL, "us", 0, -500, 500, CONFIG_PHAROS_GIMBAL_PAN_TRIM_US, 0,           \
	  "Added to every pulse of pan")                                                           \
	X(GMB_PAN_NEUT, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_PAN_NEUTRAL_MDEG,  \
	  0, "Neutral pan")                                                                        \
	X(GMB_PAN_RETR, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_PAN_RETRACT_MDEG,  \
	  0, "Retracted pan")                                                                      \
	X(GMB_TLT_MIN, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_TILT_MIN_MDEG, 0,   \
	  "Lowest tilt")                                                                           \
	X(GMB_TLT_MAX, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_TILT_MAX_MDEG, 0,   \
	  "Highest tilt")                                                                          \
	X(GMB_TLT_RATE, GIMBAL, "deg/s", 3, 1000, 2000000,                                         \
	  CONFIG_PHAROS_GIMBAL_TILT_RATE_MDEG_PER_S, 0, "Fastest tilt")                            \
	X(GMB_TLT_PW_MIN, GIMBAL, "us", 0, 500, 2500, CONFIG_PHAROS_GIMBAL_TILT_PULSE_MIN_US, 0,   \
	  "Pulse at GMB_TLT_MIN; longer than GMB_TLT_PW_MAX reverses the servo")                   \
	X(GMB_TLT_PW_MAX, GIMBAL, "us", 0, 500, 2500, CONFIG_PHAROS_GIMBAL_TILT_PULSE_MAX_US, 0,   \
	  "Pulse at GMB_TLT_MAX")                                                                  \
	X(GMB_TLT_TRIM, GIMBAL, "us", 0, -500, 500, CONFIG_PHAROS_GIMBAL_TILT_TRIM_US, 0,          \
	  "Added to every pulse of tilt")                                                          \
	X(GMB_TLT_NEUT, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_TILT_NEUTRAL_MDEG, \
	  0, "Neutral tilt")                                                                       \
	X(GMB_TLT_RETR, GIMBAL, "deg", 3, -180000, 180000, CONFIG_PHAROS_GIMBAL_TILT_RETRACT_MDEG, \
	  0, "Retracted tilt")                                                                     \
	X(GMB_RATE_TMO, GIMBAL, "s", 3, 50, 60000, CONFIG_PHAROS_GIMBAL_RATE_TIMEOUT_MS, 0,        \
	  "A rate that is not renewed ends after this")                                            \
	X(GMB_ATT_TMO, GIMBAL, "s", 3, 50, 60000, CONFIG_PHAROS_GIMBAL_ATTITUDE_TIMEOUT_MS, 0,     \
	  "An attitude of the vehicle is good for so long")                                        \
	X(GMB_MNT_SIGN, GIMBAL, "", 0, 0, 3, CONFIG_PHAROS_GIMBAL_MOUNT_SIGN, 0,                   \
	  "Signs turned round in MAVLink mount commands: sum of 1 pitch, 2 yaw")                   \
	X(GMB_ASK_DATA, GIMBAL, "", 0, 0, 1, CONFIG_PHAROS_GIMBAL_ASK_DATA, 0,                     \
	  "Ask the vehicle for its attitude and position: 0 no, 1 when they do not come")
#else
#define PARAMS_GIMBAL(X)
#endif

#define PARAMS_TABLE(X)                                                                            \
	PARAMS_LIGHT(X)                                                                            \
	PARAMS_ARBITER(X)                                                                          \
	PARAMS_THERMAL(X)                                                                          \
	PARAMS_SYNC(X)                                                                             \
	PARAMS_MAVLINK(X)                                                                          \
	PARAMS_SIGNING(X)                                                                          \
	PARAMS_ROUTING(X) PARAMS_DRONECAN(X) PARAMS_IMC(X) PARAMS_GIMBAL(X) PARAMS_OUTPUTS(X)

#endif
