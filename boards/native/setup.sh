#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# What a build (setup.sh build) or a test run (setup.sh test) needs on Debian: packages, and .venv
# from requirements.txt. Installs what is missing when root, else names it. Quick when all is there.
set -eu
cd "$(dirname "$0")/../.."
# Debian's own interpreter, whichever else a shell would find first.
PATH=/usr/sbin:/usr/bin:/sbin:/bin
export PATH

BUILD="gcc libc6-dev cmake ninja-build pkg-config libjansson-dev nettle-dev libgpiod-dev python3 python3-venv"
TEST="$BUILD clang libclang-rt-14-dev clang-format binutils shellcheck gcc-arm-none-eabi
      libnewlib-arm-none-eabi linux-source-6.12 flex bison bc make xz-utils can-utils gpiod
      iproute2"

case "${1:-build}" in
build) packages=$BUILD ;;
test) packages=$TEST ;;
*)
	echo "setup.sh: '$1' is not a set of packages; use: build, test" >&2
	exit 2
	;;
esac

missing=
for package in $packages; do
	if ! dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed'; then
		missing="$missing $package"
	fi
done
if [ -n "$missing" ]; then
	if [ "$(id -u)" -ne 0 ]; then
		echo "setup: packages are missing; as root: apt-get install$missing" >&2
		exit 1
	fi
	echo "setup: installing$missing"
	apt-get update -q
	# shellcheck disable=SC2086 # a list of words
	DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
fi

stamp=.venv/pharos.stamp
wanted=$(python3 -VV | cat - requirements.txt host/pyproject.toml | sha256sum)
if [ "$(cat "$stamp" 2>/dev/null)" != "$wanted" ]; then
	echo "setup: making .venv from requirements.txt"
	python3 -m venv --clear .venv
	.venv/bin/python -m pip install -q --disable-pip-version-check -r requirements.txt -e host
	echo "$wanted" >"$stamp"
fi
