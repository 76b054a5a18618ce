# SPDX-License-Identifier: Apache-2.0
#
# make run     set up, build, and start the light with its shell; ARGS="…" replaces its wires
# make test    set up, and run every test (tests/run.py; STAGES="unit system" picks some)
# make build   build/native/pharos
# make bench   the figures of README, from one run
# make picture docs/heat.svg, from a simulated hour
# make parameters docs/parameters.md, from the table
# make lint    clang-format, ruff, mypy, shellcheck
# make fuzz    every libFuzzer harness for FUZZ_RUNS executions each
# make format  lay out C and Python sources
# make clean

# Debian's own compilers and tools, whichever others a shell would find first.
export PATH := /usr/sbin:/usr/bin:/sbin:/bin

PRESET ?= native
# Where a ground station listens by default, and a port to connect to.
ARGS ?= --uart0 udpout:127.0.0.1:14550 --uart1 tcpin:127.0.0.1:5770
STAGES ?=
FUZZ_RUNS ?= 10000000
PYTHON = .venv/bin/python

.PHONY: run test build bench picture parameters lint fuzz format clean setup

build: setup
	@test -f build/$(PRESET)/build.ninja || cmake --preset $(PRESET) --log-level=NOTICE
	@cmake --build build/$(PRESET)

run: build
	@exec build/$(PRESET)/pharos $(ARGS)

setup:
	@boards/native/setup.sh build

test:
	@boards/native/setup.sh test
	@$(PYTHON) tests/run.py $(STAGES)

bench: build
	@$(PYTHON) tests/bench/run.py

picture: build
	@$(PYTHON) docs/heat.py

parameters: build
	@$(PYTHON) docs/parameters.py

lint:
	@boards/native/setup.sh test
	@$(PYTHON) tests/run.py lint

fuzz:
	@boards/native/setup.sh test
	@$(PYTHON) tests/run.py fuzz --fuzz-runs $(FUZZ_RUNS)

format:
	@git ls-files '*.c' '*.h' | xargs clang-format -i
	@$(PYTHON) -m ruff format host tests boards app docs

clean:
	rm -rf build
