#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# make, also on a machine that has none yet: ./make run, ./make test (see Makefile).
set -eu
cd "$(dirname "$0")"
boards/native/setup.sh make
exec make "$@"
