/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The component's metadata, general.json and parameters.json.xz: made from the parameter table at
 * build time (metadata.py), in flash. Spec: mavlink.io/en/services/component_metadata.html.
 */
#ifndef PHAROS_THREADS_METADATA_H
#define PHAROS_THREADS_METADATA_H

#include "proto/mavlink/ftp.h"

extern const struct mavlink_files metadata_files;

#endif
