# `make demo` and `make test` set up what they need in .venv, inside the checkout.

# The first of these that is Python 3.11 or newer; or say PYTHON=/path/to/python.
PYTHON ?= $(shell for python in python3.11 python3.12 python3.13 python3.14 python3 python; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	&& echo $$python && break; done)
BIN := .venv/bin
# One worker a core, one room a worker; what takes longer than 3 s of processor time is listed.
PYTEST = $(BIN)/pytest -n auto --maxprocesses 4 --dist loadgroup --cpu-limit 3 $(PYTEST_ARGS)
RENDERING_TESTS = $(addprefix tests/,mitsuba preview rendering end_to_end comparison view api \
	cli/test_rendering.py cli/test_lighting.py cli/test_libraries.py cli/test_materials_commands.py)
export PIP_ROOT_USER_ACTION := ignore
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.PHONY: help demo test slow long scalar venv lint types unit check benchmarks fuzz docs pictures clean

help:
	@echo "make demo        compose and render the bundled example into out/demo"
	@echo "make test        ruff, mypy --strict and pytest without the slow tests"
	@echo "make slow        the slow tests"
	@echo "make long        the rest: what slow tests show, for more rooms, lights and moments"
	@echo "make scalar      the tests of rendering, as on a machine without LLVM"
	@echo "make lint        ruff alone;  make types: mypy alone;  make unit: pytest alone"
	@echo "make check       ruff and mypy"
	@echo "make benchmarks  print the tables of the README and write them to out/benchmarks"
	@echo "make fuzz        give broken and hostile input of every kind to every command, and 2,000 stages"
	@echo "make docs        build the documentation into out/site"
	@echo "make pictures    draw the pictures of the documentation"
	@echo "make venv        set up .venv with the tools for development"
	@echo "make clean       remove .venv and those of the tests, out and caches"

demo: .venv/installed
	@$(BIN)/orusd demo -o out/demo
	@echo && echo "orusd is in .venv/bin:  . .venv/bin/activate"

test: lint
	$(MAKE) --jobs 2 types unit

check: lint types

venv: .venv/installed-dev

lint: .venv/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: .venv/installed-dev
	$(BIN)/mypy

unit: .venv/installed-dev
	$(PYTEST) -m "not slow"

slow: .venv/installed-dev
	$(PYTEST) -m "slow and not long"

long: .venv/installed-dev
	$(PYTEST) -m long

# DRJIT_LIBLLVM_PATH names what is not there: no other library is tried.
scalar: .venv/installed-dev
	DRJIT_LIBLLVM_PATH=$(CURDIR)/no-llvm $(PYTEST) -m "not slow" $(RENDERING_TESTS)

benchmarks: .venv/installed-dev
	@mkdir -p out/benchmarks
	for name in first_picture compose generate materials friction light scan physics; do \
		$(BIN)/python -m benchmarks.$$name --json out/benchmarks/$$name.json || exit 1; done

fuzz: .venv/installed-dev
	@mkdir -p out/fuzz
	ORUSD_STAGES=2000 $(PYTEST) tests/anystage
	$(BIN)/python -m tests.fuzz --cases 20000 --keep out/fuzz/bad --json out/fuzz/tally.json

docs: .venv-docs/installed
	NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs build --quiet
	@echo "out/site/index.html"

pictures: .venv/installed-dev
	$(BIN)/python -m docs.pictures

clean:
	rm -rf .venv .venv-blender .venv-newton .venv-torch .venv-physx .venv-mujoco-usd .venv-colmap .venv-docs .venv-usdchecker .node-gltf out dist build .pytest_cache .mypy_cache .ruff_cache .hypothesis

.venv/installed: pyproject.toml
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed and none was found:" \
		"install it (Debian, Ubuntu: apt-get install python3 python3-venv) or say" \
		"make PYTHON=/path/to/python"; exit 1; }
	@test -x $(BIN)/pip || $(PYTHON) -m venv .venv || { rm -rf .venv; echo "no virtual" \
		"environment could be made (Debian, Ubuntu: apt-get install python3-venv)"; exit 1; }
	@echo "installing into .venv"
	@$(BIN)/python -m pip install --quiet --editable ".[denoise]" || { echo "without the denoiser:" \
		"pictures stay noisy"; $(BIN)/python -m pip install --quiet --editable .; }
	@$(BIN)/orusd doctor > .venv/doctor.txt || { cat .venv/doctor.txt; exit 1; }
	@touch $@

# The site needs none of what the toolkit needs.
.venv-docs/installed: pyproject.toml
	@test -x .venv-docs/bin/pip || $(PYTHON) -m venv .venv-docs
	.venv-docs/bin/python -m pip install --quiet --upgrade "pip>=25.1"
	.venv-docs/bin/python -m pip install --quiet --group docs
	@touch $@

# pip reads dependency groups since 25.1.
.venv/installed-dev: .venv/installed
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --group dev
	@touch $@
