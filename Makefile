# SPDX-License-Identifier: GPL-3.0-or-later
# Everything runs in .venv, which is made when first needed; nobody has to activate it.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
SHELL := /bin/bash

VENV := .venv
BIN := $(VENV)/bin
CFCLIENT := .venv-cfclient
PIP := -m pip install --quiet --disable-pip-version-check --retries 10 --no-compile

PLATFORM ?= cf2

C_SOURCES := $(wildcard firmware_app/core/*.[ch] firmware_app/app/*.[ch] firmware_app/host/*.[ch])
PLAN := tests/bench/plan
BUILD_SCRIPTS := ground/build_extensions.py ground/core_build.py ground/sim/firmware_build.py
C_WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Wcast-qual -Werror

.PHONY: help
help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

.PHONY: setup
setup: build/.built ## Create .venv with what flies; compile the C code for this machine

.PHONY: dev
dev: setup $(VENV)/.dev ## Add what tests, checks and benchmarks need

$(VENV)/.installed: pyproject.toml
	tests/tools/debian_packages.sh host
	python3 -m venv $(VENV)
	$(BIN)/python $(PIP) --editable '.[plot,compile]'
	@touch $@

build/.built: $(VENV)/.installed $(C_SOURCES) $(BUILD_SCRIPTS)
	$(BIN)/python -m ground.build_extensions
	@mkdir -p $(@D) && touch $@

$(VENV)/.dev: $(VENV)/.installed
	$(BIN)/python $(PIP) 'wayflie[bench,dev]'
	@touch $@

.PHONY: demo
demo: setup ## Fly a simulated Crazyflie and look at it [HEADLESS=1] [JSON=out.json]
	$(BIN)/wayflie demo $(if $(HEADLESS),--headless) $(if $(JSON),--json $(JSON))

.PHONY: sim
sim: setup ## Run only the simulated Crazyflie, for wayflie, cfclient or a script [WORLD=flat]
	$(BIN)/wayflie sim $(if $(WORLD),--world $(WORLD))

.PHONY: ground
ground: setup ## Run only the ground station and its page [URI=radio://...]
	$(BIN)/wayflie ground $(if $(URI),--uri $(URI))

.PHONY: test
test: dev ## Run the tests, one more at a time than processors: many wait for a drone [WORKERS=3]
	tests/tools/debian_packages.sh test chip web
	$(BIN)/pytest -n $(or $(WORKERS),$$(($$(nproc) + 1))) --dist worksteal tests --ignore tests/cfclient

.PHONY: test-web
test-web: dev ## Look at the page in Chromium, with simulated drones; pictures in build/screens
	tests/tools/debian_packages.sh web
	$(BIN)/pytest tests/web

.PHONY: test-cfclient
test-cfclient: setup $(CFCLIENT)/.installed ## Drive the real cfclient against the simulated Crazyflie [MINUTES=10]
	QT_QPA_PLATFORM=offscreen MINUTES=$(MINUTES) $(CFCLIENT)/bin/python -m pytest -rP --confcutdir tests/cfclient tests/cfclient

$(CFCLIENT)/.installed: pyproject.toml
	tests/tools/debian_packages.sh host cfclient
	python3 -m venv $(CFCLIENT)
	$(CFCLIENT)/bin/python $(PIP) 'cfclient==2026.8.1' 'pytest>=9,<10' 'pytest-timeout>=2.4,<3'
	@touch $@

.PHONY: check
check: dev ## Lint, types, formatting, strict C warnings
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run -Werror firmware_app/{core,app,host}/*.[ch] tests/{,bench/}*/*.[ch] $(PLAN)/*.cpp
	$(BIN)/python -m tests.tools.analyse gcc
	gcc -std=c11 -O2 $(C_WARNINGS) -fsyntax-only -Ifirmware_app/core -Itests/firmware $(PLAN)/*.c

.PHONY: analyse
analyse: setup ## Let gcc, clang, clang-tidy and cppcheck read the C code
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.analyse

.PHONY: prove
prove: setup ## Prove packets, geometry, scan and grid free of run-time errors, with Frama-C
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.prove

.PHONY: fuzz
fuzz: dev ## Feed everything that takes outside data with nonsense [SECONDS=60 for each target]
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.fuzz $(or $(SECONDS),60)
	$(BIN)/python -m tests.tools.fuzz_python $(or $(SECONDS),60)

.PHONY: mutate
mutate: dev ## Change lines of the C code: does a test fail? [PARTS=guard] [EACH=6 changes per file]
	$(BIN)/python -m tests.tools.mutate $(PARTS) $(if $(EACH),--each $(EACH))

.PHONY: firmware
firmware: need-base ## Build the app into the real firmware: CRAZYFLIE_BASE=... [PLATFORM=cf2|cf21bl]
	tests/tools/debian_packages.sh chip
	$(MAKE) -C firmware_app CRAZYFLIE_BASE=$(abspath $(CRAZYFLIE_BASE)) $(PLATFORM)_defconfig
	$(MAKE) -C firmware_app CRAZYFLIE_BASE=$(abspath $(CRAZYFLIE_BASE))
	@! test -f $(VENV)/.dev || $(BIN)/python -m tests.tools.elf_tables firmware_app/build/$(PLATFORM).elf

.PHONY: need-base
need-base:
	@test -f '$(CRAZYFLIE_BASE)/tools/make/oot.mk' || { \
	  echo 'CRAZYFLIE_BASE must be a checkout of crazyflie-firmware, with its submodules' >&2; exit 2; }

.PHONY: flash
flash: $(CFCLIENT)/.installed ## Send the built firmware to a Crazyflie [PLATFORM=...] [URI=radio://...]
	$(CFCLIENT)/bin/cfloader flash firmware_app/build/$(PLATFORM).bin stm32-fw \
	  -w $(or $(URI),radio://0/80/2M/E7E7E7E7E7)

.PHONY: sizes
sizes: dev ## Print what core and app need on the chip: RAM, flash, stack
	tests/tools/debian_packages.sh chip
	$(BIN)/python -m tests.tools.sizes

.PHONY: docs
docs: dev ## Write the tables of parameters and log variables in DESIGN.md anew
	$(BIN)/python -m tests.tools.docs

.PHONY: wheel
wheel: ## Build the wheel, install it into an empty environment, fly from an empty folder
	tests/tools/debian_packages.sh host
	tests/tools/try_wheel.sh

.PHONY: picture
picture: dev ## Take the pictures of the README anew
	tests/tools/debian_packages.sh web
	$(BIN)/python -m tests.tools.picture ground/web/page.png ground/web/flight.webp

OMPL_INCLUDE ?= $(firstword $(wildcard /usr/include/ompl-*)) /usr/include/eigen3

.PHONY: bench-ompl
bench-ompl: setup ## Compile what `wayflie bench plan` compares with: OMPL, used by nothing else
	tests/tools/debian_packages.sh ompl
	@$(MAKE) --no-print-directory build/bench-plan/drive_ompl

build/bench-plan/drive_ompl: $(wildcard $(PLAN)/*.h) $(PLAN)/drive_ompl.cpp $(PLAN)/drive.c $(PLAN)/exact.c $(PLAN)/exact_search.c
	@mkdir -p $(@D)
	for part in drive exact exact_search; do \
	  gcc -std=c11 -O3 -march=native -c $(PLAN)/$$part.c -o $(@D)/$$part.o || exit; done
	g++ -std=c++17 -O3 -march=native -DNDEBUG -Wall -Wextra -I$(PLAN) \
	  $(addprefix -isystem,$(OMPL_INCLUDE)) $(PLAN)/drive_ompl.cpp $(@D)/*.o -lompl -o $@

.PHONY: clean
clean: ## Remove everything that was built, the environments too
	rm -rf $(VENV) $(CFCLIENT) build dist *.egg-info firmware_app/build
	rm -rf .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -prune -exec rm -rf {} +
	find ground firmware_app \( -name '*.so' -o -name '*.o' -o -name '*.a' -o -name '.*.cmd' \) -delete
