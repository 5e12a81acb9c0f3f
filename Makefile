# make demo | test | slow | real | lint | types | clean; the environment in .venv is made when it is missing or out of date

SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.made
# each is run, not only looked up: a version manager may put names on the path that fail when they are called
PYTHONS ?= python3.13 python3.12 python3.11 python3 python
# a file stays with one worker: its fixtures and kernels are made once; more than four workers mostly import
SPREAD ?= -n auto --maxprocesses 4 --dist loadfile

.PHONY: demo test slow real lint types environment clean

demo: $(STAMP)
	$(BIN)/fusion demo -o out/demo --overwrite

test: $(STAMP)
	$(BIN)/python -m pytest -m "not real and not slow" $(SPREAD)

slow: $(STAMP)
	$(BIN)/python -m pytest -m "slow and not real"

real: $(STAMP)
	$(BIN)/python -m pytest -m real

lint: $(STAMP)
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: $(STAMP)
	$(BIN)/mypy

environment: $(STAMP)

$(STAMP): pyproject.toml
	@set -euo pipefail; \
	found=""; \
	for python in $(PYTHONS); do \
	  if "$$python" -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' \
	    >/dev/null 2>&1; then found="$$python"; break; fi; \
	done; \
	if [ -z "$$found" ]; then \
	  echo "make: no Python 3.11 to 3.13 with the module venv among: $(PYTHONS);" \
	    "found $$(python3 --version 2>&1 | head -n 1); install one (Debian, Ubuntu: apt-get install python3 python3-venv)" \
	    "or name it: make PYTHONS=/path/to/python3.12" >&2; \
	  exit 1; \
	fi; \
	if ! $(BIN)/python -c 'import pip' >/dev/null 2>&1; then \
	  echo "making $(VENV) with $$("$$found" --version)"; \
	  "$$found" -m venv --clear $(VENV); \
	fi; \
	echo "installing into $(VENV): some 2 GB, a minute or more the first time"; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'; \
	touch $(STAMP)

clean:
	rm -rf $(VENV) out build dist .mypy_cache .ruff_cache .pytest_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
