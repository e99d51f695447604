# SPDX-License-Identifier: GPL-3.0-or-later
# Everything runs in .venv, which `make setup` creates; nobody has to activate it.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
SHELL := /bin/bash

VENV := .venv
BIN := $(VENV)/bin
CFCLIENT := .venv-cfclient
PIP := -m pip install --quiet --disable-pip-version-check --retries 10

PLATFORM ?= cf2

CORE_C := $(wildcard firmware_app/core/*.c)
CORE_H := $(wildcard firmware_app/core/*.h)
C_SOURCES := $(CORE_C) $(CORE_H) $(wildcard firmware_app/app/*.[ch] firmware_app/host/*.[ch])
C_TESTS := $(wildcard tests/*/*.c tests/bench/*/*.[ch] tests/bench/*/*.cpp)
PLAN := tests/bench/plan
BUILD_SCRIPTS := ground/core_build.py ground/sim/firmware_build.py
C_WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Wcast-qual -Werror

.PHONY: help
help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

.PHONY: setup
setup: $(VENV)/.built ## Create .venv with everything in it; compile the C code for this machine

$(VENV)/.installed: pyproject.toml
	tests/tools/debian_packages.sh host
	python3 -m venv $(VENV)
	$(BIN)/python $(PIP) --editable '.[plot,bench,dev]'
	@touch $@

$(VENV)/.built: $(VENV)/.installed $(C_SOURCES) $(BUILD_SCRIPTS)
	$(BIN)/python -m ground.core_build
	$(BIN)/python -m ground.sim.firmware_build
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
test: setup ## Run the tests (two processes, under ten minutes)
	tests/tools/debian_packages.sh test
	$(BIN)/pytest -n 2 tests --ignore tests/cfclient

.PHONY: test-web
test-web: setup ## Look at the page in Chromium, with simulated drones; pictures in build/screens
	tests/tools/debian_packages.sh test
	$(BIN)/pytest tests/web

.PHONY: test-cfclient
test-cfclient: setup $(CFCLIENT)/.installed ## Drive the real cfclient against the simulated Crazyflie [MINUTES=10]
	QT_QPA_PLATFORM=offscreen MINUTES=$(MINUTES) $(CFCLIENT)/bin/python -m pytest -rP --confcutdir tests/cfclient tests/cfclient

$(CFCLIENT)/.installed: pyproject.toml
	tests/tools/debian_packages.sh cfclient
	python3 -m venv $(CFCLIENT)
	$(CFCLIENT)/bin/python $(PIP) 'cfclient==2026.8.1' 'pytest>=9,<10' 'pytest-timeout>=2.4,<3'
	@touch $@

.PHONY: check
check: setup ## Lint, types, formatting, strict C warnings
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run -Werror $(C_SOURCES) $(C_TESTS)
	gcc -std=c11 -O2 $(C_WARNINGS) -fsyntax-only $(CORE_C)
	gcc -std=c11 -O2 $(C_WARNINGS) -fsyntax-only -Ifirmware_app/core -Itests/firmware $(wildcard $(PLAN)/*.c)

.PHONY: analyse
analyse: setup ## Let gcc, clang, clang-tidy and cppcheck read the C code
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.analyse

.PHONY: prove
prove: setup ## Prove packets, geometry, scan and grid free of run-time errors, with Frama-C
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.prove

.PHONY: fuzz
fuzz: setup ## Feed everything that takes outside data with nonsense [SECONDS=60 for each target]
	tests/tools/debian_packages.sh analysis
	$(BIN)/python -m tests.tools.fuzz $(or $(SECONDS),60)
	$(BIN)/python -m tests.tools.fuzz_python $(or $(SECONDS),60)

.PHONY: firmware
firmware: need-base ## Build the app into the real firmware: CRAZYFLIE_BASE=... [PLATFORM=cf2|cf21bl]
	$(MAKE) -C firmware_app CRAZYFLIE_BASE=$(abspath $(CRAZYFLIE_BASE)) $(PLATFORM)_defconfig
	$(MAKE) -C firmware_app CRAZYFLIE_BASE=$(abspath $(CRAZYFLIE_BASE))
	@! test -x $(BIN)/python || $(BIN)/python -m tests.tools.elf_tables firmware_app/build/$(PLATFORM).elf

.PHONY: need-base
need-base:
	@test -f '$(CRAZYFLIE_BASE)/tools/make/oot.mk' || { \
	  echo 'CRAZYFLIE_BASE must be a checkout of crazyflie-firmware, with its submodules' >&2; exit 2; }

.PHONY: flash
flash: $(CFCLIENT)/.installed ## Send the built firmware to a Crazyflie [PLATFORM=...] [URI=radio://...]
	$(CFCLIENT)/bin/cfloader flash firmware_app/build/$(PLATFORM).bin stm32-fw \
	  -w $(or $(URI),radio://0/80/2M/E7E7E7E7E7)

.PHONY: sizes
sizes: setup ## Print what core and app need on the chip: RAM, flash, stack
	$(BIN)/python -m tests.tools.sizes

.PHONY: docs
docs: setup ## Write the tables of parameters and log variables in DESIGN.md anew
	$(BIN)/python -m tests.tools.docs

.PHONY: wheel
wheel: ## Build the wheel, install it into an empty environment, fly from an empty folder
	tests/tools/debian_packages.sh host
	tests/tools/try_wheel.sh

.PHONY: picture
picture: setup ## Take the pictures of the README anew
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
	rm -rf $(VENV) $(CFCLIENT) build *.egg-info firmware_app/build
	find . -name __pycache__ -prune -exec rm -rf {} +
	find ground firmware_app \( -name '*.so' -o -name '*.o' -o -name '*.a' -o -name '.*.cmd' \) -delete
