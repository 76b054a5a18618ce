#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# setup.sh make|build|host|test: what make, a build, the command .venv/bin/pharos or a test run needs
# on Debian, each with what stands before it. Debian's packages are installed when root and named
# otherwise; Python's go into .venv. Quick and silent when all is there, else a line for each step.
set -eu
cd "$(dirname "$0")/../.."
# Debian's own interpreter, whichever else a shell would find first.
PATH=/usr/sbin:/usr/bin:/sbin:/bin
export PATH

BUILD="make gcc libc6-dev cmake ninja-build pkg-config libjansson-dev libinih-dev nettle-dev
       libgpiod-dev python3 python3-venv"
# The guest's of tests/linux. Debian 12 has it in its security archive.
KERNEL=linux-source-6.12
TEST="$BUILD clang libclang-rt-dev binutils shellcheck gcc-arm-none-eabi libnewlib-arm-none-eabi
      $KERNEL flex bison bc xz-utils can-utils gpiod iproute2"

wanted=${1:-build}
case "$wanted" in
make) packages="make" ;;
build | host) packages=$BUILD ;;
test) packages=$TEST ;;
*)
	echo "setup.sh: '$wanted' is not a set of packages; use: make, build, host, test" >&2
	exit 2
	;;
esac

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# dots EVERY WORD: a dot for every EVERY lines of the input that have WORD in them.
dots() {
	seen=0
	while read -r line; do
		case $line in
		*"$2"*)
			seen=$((seen + 1))
			[ $((seen % $1)) -ne 0 ] || printf .
			;;
		esac
	done
}

# step WHAT EVERY WORD COMMAND…: runs the command and tells of it in a line, with dots for its output,
# which took() ends; the output itself is shown when it fails.
step() {
	printf 'setup: %s ' "$1"
	every=$2 word=$3
	shift 3
	start=$(date +%s%N)
	{
		status=0
		"$@" 2>&1 || status=$?
		echo "$status" >"$scratch/status"
	} | tee "$scratch/log" | dots "$every" "$word"
	if [ "$(cat "$scratch/status")" -ne 0 ]; then
		printf ' failed:\n'
		cat "$scratch/log" >&2
		exit 1
	fi
}

# took [SIZE]: how much the step fetched, and the seconds it took.
took() {
	tenths=$((($(date +%s%N) - start) / 100000000))
	printf ' %s%d.%d s\n' "${1:+$1 in }" $((tenths / 10)) $((tenths % 10))
}

apt() {
	LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
		apt-get -q --no-install-recommends -o Dir::Etc::SourceParts="$sources" "$@"
}

fetch_lists() {
	step "fetching the lists of packages" 1 Get: apt update
	took "$(sed -n 's/^Fetched \(.*B\) in .*/\1/p' "$scratch/log")"
}

pip() {
	.venv/bin/python -m pip --disable-pip-version-check --no-input "$@"
}

# --- Debian's packages ---------------------------------------------------------------------------
# shellcheck disable=SC2086 # a list of words
{
	dpkg-query -W -f '${db:Status-Status} ${Package}\n' $packages 2>/dev/null |
		sed -n 's/^installed //p' >"$scratch/installed"
	missing=$(printf '%s\n' $packages | grep -vxF -f "$scratch/installed" | tr '\n' ' ')
}
if [ -n "$missing" ]; then
	if [ "$(id -u)" -ne 0 ]; then
		echo "setup: packages are missing; as root: apt-get install $missing" >&2
		exit 1
	fi
	sources=/etc/apt/sources.list.d
	fetch_lists
	if [ "$wanted" = test ] && ! apt-cache show "$KERNEL" >/dev/null 2>&1; then
		# A bare Debian 12 does not name that archive: it is asked this once.
		sources=$scratch/sources
		cp -r /etc/apt/sources.list.d "$sources"
		# shellcheck disable=SC1091 # sets VERSION_CODENAME
		. /etc/os-release
		# It lies beside the archive that this machine uses.
		# shellcheck disable=SC2016 # apt's own variable
		archive=$(apt-get indextargets --format '$(SITE)' | grep -v security | head -n 1)
		echo "deb $archive-security $VERSION_CODENAME-security main" >"$sources/security.list"
		fetch_lists
	fi
	# shellcheck disable=SC2086 # a list of words
	plan=$(apt install --assume-no $missing 2>&1 || true)
	count=$(echo "$plan" | sed -n 's/^.* \([0-9]*\) newly installed.*/\1/p')
	size=$(echo "$plan" | sed -n 's/^Need to get \(.*\) of archives.*/\1/p')
	echo "setup: missing: $missing"
	# shellcheck disable=SC2086
	step "fetching $count packages, $size" 5 Get: apt install -y --download-only $missing
	took
	# Where nothing is replaced that worked, files need not reach the disk one by one.
	quick=$(echo "$plan" | sed -n 's/^0 upgraded.*/-oDpkg::Options::=--force-unsafe-io/p')
	# shellcheck disable=SC2086
	step "installing them" 5 "Setting up" apt install -y --no-download $quick $missing
	took
	sync &
fi
if [ "$wanted" = make ]; then
	exit
fi

# --- Python's, in .venv --------------------------------------------------------------------------
stamp() {
	python3 -VV | cat - "$@" | sha256sum
}

build_stamp=$(stamp requirements.txt)
if [ "$(cat .venv/build.stamp 2>/dev/null)" != "$build_stamp" ]; then
	step "making .venv" 1 "" python3 -m venv --clear .venv
	took
	step "fetching Python packages" 1 Saved pip download -r requirements.txt -d "$scratch/wheels"
	size=$(du -cb "$scratch/wheels"/* | tail -n 1 | cut -f 1)
	took "$((size / 1000000)) MB"
	step "installing them" 1 Processing \
		pip install --no-compile --no-index --find-links "$scratch/wheels" -r requirements.txt
	took
	echo "$build_stamp" >.venv/build.stamp
fi

case "$wanted" in
host) option=--constraint ;; # only what the package needs, in the tests' versions
test) option=--requirement ;;
*) exit ;;
esac
more_stamp=$(stamp requirements-test.txt host/pyproject.toml app/version.h)
if [ "$(cat ".venv/$wanted.stamp" 2>/dev/null)" != "$more_stamp" ]; then
	step "fetching and installing more Python packages" 1 Collecting \
		pip install --no-compile $option requirements-test.txt --editable host
	took
	echo "$more_stamp" >".venv/$wanted.stamp"
fi
