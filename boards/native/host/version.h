/* SPDX-License-Identifier: Apache-2.0 */
/* The program's version. The build may give another (a tag, a commit). */
#ifndef NATIVE_HOST_VERSION_H_
#define NATIVE_HOST_VERSION_H_

#ifndef PHAROS_VERSION
#define PHAROS_VERSION "0.1.0"
#endif

#endif
