#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# make, also on a machine that has none yet: ./make run, ./make test (see Makefile).
set -eu
cd "$(dirname "$0")"
if ! command -v make >/dev/null 2>&1; then
	if [ "$(id -u)" -ne 0 ]; then
		echo "./make: make is missing; as root: apt-get install make" >&2
		exit 1
	fi
	apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q make
fi
exec make "$@"
