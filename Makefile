# make demo | test | slow | real | lint | types | docs | figures | clean; the environment in .venv is made when it is missing or out of date

SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
# bytecode is written when a module is first imported: most never is; of those whose sources warn (found in 3.11 and
# 3.13 by compiling all) it is made unheard. Where a machine forbids to write it, every process would read all libraries
# from their sources: 3.6 instead of 1.6 s of processor to import what `fusion turntable` does, and many tests start some
# (`pytest -m slow tests/batch` took 84 instead of 26 s)
unexport PYTHONDONTWRITEBYTECODE
WARNING := taichi open3d ipywidgets
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
# what demo needs, and beside it what tests and checks need
STAMP := $(VENV)/.made
TOOLS := $(VENV)/.made_tools
# what the site is made with lies over that, so that tests do not see it: those of what a plain install lacks stay skipped
SITE := $(VENV)/site
SITE_MADE := $(SITE)/.made
# each is run, not only looked up: a version manager may put names on the path that fail when they are called
PYTHONS ?= python3.13 python3.12 python3.11 python3 python
# a file stays with one worker: its fixtures and kernels are made once; more than four workers mostly import
SPREAD ?= -n auto --maxprocesses 4 --dist loadfile
# many of the slow ones use two cores themselves, or wait for a device's clock
SLOW_SPREAD ?= -n auto --maxprocesses 2 --dist loadfile

.PHONY: demo test slow real lint types docs figures environment clean

demo: $(STAMP)
	$(BIN)/fusion demo -o out/demo --overwrite

test: $(TOOLS)
	$(BIN)/python -m pytest -m "not real and not slow" $(SPREAD)

slow: $(TOOLS)
	$(BIN)/python -m pytest -m "slow and not real and not alone" $(SLOW_SPREAD)
	$(BIN)/python -m pytest -m "alone"

real: $(TOOLS)
	$(BIN)/python -m pytest -m real $(SLOW_SPREAD)

lint: $(TOOLS)
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: $(TOOLS)
	$(BIN)/mypy

# without a network: pages need nothing but themselves
docs: $(SITE_MADE)
	rm -rf out/site
	$(SITE)/bin/python -m sphinx -b html -W --keep-going -q -d out/site_build/doctrees docs out/site
	$(SITE)/bin/python -m tools.documentation.standalone out/site

# README's figures that take minutes, from the recordings that FUSION_SHARED names, into docs/measured.md
figures: $(TOOLS)
	$(BIN)/python -m tools.reproduce.figures

environment: $(TOOLS)

# made anew whenever its list changes: what an older list brought would stay, open3d's two builds in one folder
$(STAMP): pyproject.toml
	@set -euo pipefail; \
	found=""; \
	for needed in 'venv, ensurepip' venv; do \
	  for python in $(PYTHONS); do \
	    if [ -z "$$found" ] && "$$python" -c "import sys, $$needed; sys.exit(not (3, 11) <= sys.version_info < (3, 14))" \
	      >/dev/null 2>&1; then found="$$python"; fi; \
	  done; \
	done; \
	if [ -z "$$found" ]; then \
	  echo "make: no Python 3.11 to 3.13 with the module venv among: $(PYTHONS);" \
	    "found $$(python3 --version 2>&1 | head -n 1); install one (Debian, Ubuntu: apt-get install python3 python3-venv)" \
	    "or name it: make PYTHONS=/path/to/python3.12" >&2; \
	  exit 1; \
	fi; \
	"$$found" -m tools.system_packages; \
	echo "making $(VENV) with $$("$$found" --version): some 1 GB, a minute the first time"; \
	"$$found" -m venv --clear $(VENV); \
	$(PIP) --editable .; \
	site=$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))'); \
	for package in $(WARNING); do $(BIN)/python -W ignore -m compileall -q "$$site/$$package"; done; \
	touch $(STAMP)

$(TOOLS): $(STAMP)
	@echo "installing what tests and checks need: some 0.8 GB"
	@$(PIP) --editable '.[dev]'
	@touch $(TOOLS)

$(SITE_MADE): $(STAMP)
	@echo "installing what the site is made with: some 0.3 GB"
	@$(BIN)/python -m venv --clear $(SITE)
	@site=$$($(SITE)/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))'); \
	$(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))' > "$$site/program.pth"
	@$(SITE)/bin/python -m pip install --quiet --disable-pip-version-check --no-compile --editable '.[docs,batch]'
	@touch $(SITE_MADE)

clean:
	rm -rf $(VENV) out build dist .mypy_cache .ruff_cache .pytest_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
