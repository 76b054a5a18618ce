/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The version, as the light tells it over every protocol: here alone. The native program
 * (boards/native/board.cmake) and the Python package (host/setup.py) read the three numbers.
 */
#ifndef PHAROS_VERSION_H
#define PHAROS_VERSION_H

#define PHAROS_VERSION_MAJOR 0
#define PHAROS_VERSION_MINOR 1
#define PHAROS_VERSION_PATCH 0

#define PHAROS_VERSION_TEXT_(major, minor, patch) #major "." #minor "." #patch
#define PHAROS_VERSION_TEXT(major, minor, patch)  PHAROS_VERSION_TEXT_(major, minor, patch)
/* "major.minor.patch" */
#define PHAROS_VERSION                                                                             \
	PHAROS_VERSION_TEXT(PHAROS_VERSION_MAJOR, PHAROS_VERSION_MINOR, PHAROS_VERSION_PATCH)

#endif
