# SPDX-License-Identifier: Apache-2.0
#
# What `make help` prints; ./make is make on a machine that has none yet:
#
# make run              set up, build and start the light with its shell; ARGS="…" replaces its wires
# make build            set up and build the light alone: build/native/pharos
# make host             set up the command .venv/bin/pharos and its package
# make test             set up and run every test; STAGES="lint native" picks some
# make lint             the stage lint: clang-format, ruff, mypy, shellcheck
# make fuzz             the stage fuzz, FUZZ_RUNS=10000000 executions of each harness
# make simulate         worlds of lights, faults and attackers: SEEDS=1:301, or SEED=42 told at length;
#                       WORKERS=tcp://HOST:8786 spreads them over a Dask cluster
# make simulate-speedup  do two workers find the same, nearly twice as fast? on an idle machine: SEEDS=1:201
# make simulate-bugs    does that hunt find bugs? one after the other is built in: BUGS=no-latch
# make simulate-worker  this machine works for that cluster: SCHEDULER=tcp://HOST:8786
# make simulate-powerup  power-ups with chips that are late, silent or broken: SEEDS=1:10001
# make simulate-store   a power cut at every byte of what the store writes: CUTS=1000000
# make coverage         which lines and branches of app/ the suite takes: build/coverage/html
# make mutants          small changes of the code that no test notices: SEED=1 COUNT=300
#                       WHERE="app/core app/proto"; takes hours
# make bench            the figures of README, from one run
# make picture          docs/heat.svg, from a simulated hour
# make parameters       docs/parameters.md, from the table
# make format           lay out the sources in C and Python
# make clean            remove build/
# make help             print this

# Debian's own compilers and tools, whichever others a shell would find first.
export PATH := /usr/sbin:/usr/bin:/sbin:/bin

PRESET ?= native
BUILD = build/$(PRESET)
# Where a ground station listens by default, and a port to connect to.
ARGS ?= --uart0 udpout:127.0.0.1:14550 --uart1 tcpin:127.0.0.1:5770
STAGES ?=
FUZZ_RUNS ?= 10000000
SEEDS ?= 1:301
SEED ?=
WORKERS ?= local
CUTS ?= 1000000
COUNT ?= 300
WHERE ?=
SCHEDULER ?=
PYTHON = .venv/bin/python

.DEFAULT_GOAL = help
.PHONY: help run build host test lint fuzz bench picture parameters format clean
.PHONY: simulate simulate-bugs simulate-speedup simulate-worker simulate-powerup simulate-store coverage mutants
.PHONY: tools test-tools

help:
	@sed -n '/^# make /,/^$$/s/^# //p' $(MAKEFILE_LIST)

run: build
	@exec $(BUILD)/pharos $(ARGS)

build: tools $(BUILD)/build.ninja
	@cmake --build $(BUILD) --target app

$(BUILD)/build.ninja: | tools
	@echo "configuring $(BUILD)"
	@cmake --preset $(PRESET) --log-level=NOTICE >/dev/null

tools:
	@boards/native/setup.sh build

test-tools:
	@boards/native/setup.sh test

host:
	@boards/native/setup.sh host

test: test-tools
	@$(PYTHON) tests/run.py $(STAGES)

lint: test-tools
	@$(PYTHON) tests/run.py lint

fuzz: test-tools
	@$(PYTHON) tests/run.py fuzz --fuzz-runs $(FUZZ_RUNS)

simulate: test-tools build
	@$(PYTHON) tests/sim/world/simulate.py $(if $(SEED),--seed $(SEED),--seeds $(SEEDS) --workers $(WORKERS))

simulate-worker: test-tools build
	@PYTHONPATH=tests/sim/world .venv/bin/dask worker $(SCHEDULER) --nworkers -1 --nthreads 1

simulate-speedup: test-tools build
	@$(PYTHON) tests/sim/world/speedup.py --seeds $(SEEDS)

simulate-bugs: test-tools build
	@$(PYTHON) tests/sim/world/seeded.py $(BUGS)

simulate-powerup: test-tools build
	@$(PYTHON) tests/sim/powerup/powerup.py --seeds $(SEEDS)

simulate-store: tools $(BUILD)/build.ninja
	@cmake --build $(BUILD) --target store_sim
	@$(BUILD)/tests/sim/store_sim --cuts $(CUTS)

bench: test-tools $(BUILD)/build.ninja
	@cmake --build $(BUILD)
	@$(PYTHON) tests/bench/run.py

picture: test-tools build
	@$(PYTHON) docs/heat.py

parameters: build
	@$(PYTHON) docs/parameters.py

format: test-tools
	@git ls-files '*.c' '*.h' | xargs .venv/bin/clang-format -i
	@$(PYTHON) -m ruff format host tests boards app docs

clean:
	rm -rf build

mutants: test-tools
	@$(PYTHON) tests/mutation/mutants.py --seed $(or $(SEED),1) --count $(COUNT) $(WHERE)

coverage: test-tools
	@cmake --preset coverage --log-level=NOTICE >/dev/null
	@cmake --build build/coverage
	@find build/coverage -name '*.gcda' -delete
	-@ctest --test-dir build/coverage -Q -j 2
	-@PHAROS_BUILD=build/coverage $(PYTHON) -m pytest -q -n 2 tests host
	-@PHAROS_BUILD=build/coverage $(PYTHON) tests/sim/world/simulate.py --seeds $(SEEDS)
	@mkdir -p build/coverage/html
	@.venv/bin/gcovr build/coverage
