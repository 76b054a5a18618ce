/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the host has to tell the user while the light runs: a wire that fails, one that is back.
 *
 * To standard error as "pharos: …"; or, once the device's log takes it, through that, so that the
 * line being typed in the shell is not torn.
 */
#ifndef NATIVE_HOST_SAY_H_
#define NATIVE_HOST_SAY_H_

/* One line, without its end; cut after 255 bytes. */
__attribute__((format(printf, 1, 2))) void host_say(const char *format, ...);

/* Real time only: from now on lines go to take. It may be called from anywhere in the host. */
void host_say_through(void (*take)(const char *text));

#endif
