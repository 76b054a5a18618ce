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
# make simulate worlds of lights, faults and attackers, from seeds: SEEDS=1:301, SEED=42 tells one,
#              WORKERS=tcp://HOST:8786 spreads them over a Dask cluster
# make simulate-worker SCHEDULER=tcp://HOST:8786: this machine's cores work for that cluster
# make simulate-store power cut at every byte of the store's writes: CUTS=1000000
# make format  lay out C and Python sources
# make clean

# Debian's own compilers and tools, whichever others a shell would find first.
export PATH := /usr/sbin:/usr/bin:/sbin:/bin

PRESET ?= native
# Where a ground station listens by default, and a port to connect to.
ARGS ?= --uart0 udpout:127.0.0.1:14550 --uart1 tcpin:127.0.0.1:5770
STAGES ?=
FUZZ_RUNS ?= 10000000
SEEDS ?= 1:301
SEED ?=
WORKERS ?= local
CUTS ?= 1000000
SCHEDULER ?=
PYTHON = .venv/bin/python

.PHONY: run test build bench picture parameters lint fuzz simulate simulate-worker simulate-store format clean setup

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

simulate:
	@boards/native/setup.sh test
	@$(MAKE) --no-print-directory build
	@$(PYTHON) tests/sim/world/run.py $(if $(SEED),--seed $(SEED),--seeds $(SEEDS) --workers $(WORKERS))

simulate-worker:
	@boards/native/setup.sh test
	@$(MAKE) --no-print-directory build
	@PYTHONPATH=tests/sim/world .venv/bin/dask worker $(SCHEDULER) --nworkers -1 --nthreads 1

simulate-store: build
	@build/$(PRESET)/tests/sim/store_sim --cuts $(CUTS)

format:
	@git ls-files '*.c' '*.h' | xargs clang-format -i
	@$(PYTHON) -m ruff format host tests boards app docs

clean:
	rm -rf build
