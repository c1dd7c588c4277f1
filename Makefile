# Everything runs from .venv. Comparing logs takes the libraries of requirements-compare.lock; the first target that needs
# more, such as make test, adds those of requirements.lock.
VENV := .venv
BIN := $(VENV)/bin
COMPARE := $(VENV)/.compare
STAMP := $(VENV)/.installed
DOCS := .venv-docs
UV := $(shell command -v uv 2>/dev/null)
PYTHON ?= python3
unexport PYTHONDONTWRITEBYTECODE  # else each start compiles all that it imports: 5 s of CPU time

.DEFAULT_GOAL := help
.PHONY: help install demo test test-slow test-viewer test-daemons check format bench docs lock clean

help:  ## what can be made
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-13s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(STAMP)  ## .venv with all the locked libraries and dr_lab

ifdef UV
INSTALL := $(UV) pip install --quiet --python $(BIN)/python
else
INSTALL := $(BIN)/pip install --quiet --no-compile
endif

$(COMPARE): requirements-compare.lock pyproject.toml
ifdef UV
	@test -x $(BIN)/python || $(UV) venv --quiet --python '>=3.11' $(VENV)
else
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "dr_lab needs Python 3.11 or newer: make PYTHON=…")'
	@test -x $(BIN)/pip || $(PYTHON) -m venv $(VENV)
endif
	$(INSTALL) --require-hashes -r requirements-compare.lock
	$(INSTALL) --no-deps --editable .
	@touch $@

$(STAMP): requirements.lock $(COMPARE)
	$(INSTALL) --require-hashes -r requirements.lock
	@touch $@

demo: $(COMPARE)  ## find what the Furuta pendulum's model lacks, add it, and print the ladder
	$(BIN)/dr-lab close model=furuta measurements=furuta
	@echo
	@echo "To type dr-lab yourself: . $(BIN)/activate"
	@test -e $(STAMP) || echo "To train policies, too: make install, which adds PyTorch and what goes with it (6 GB)"

test: $(STAMP)  ## the tests, without those that take minutes, open the viewer or need daemons
	$(BIN)/pytest --numprocesses auto --dist loadfile

test-slow: $(STAMP)  ## the tests that take minutes
	$(BIN)/pytest -m slow

test-viewer: $(STAMP)  ## the tests that look at recordings in a headless Rerun viewer (Debian's libvulkan1, mesa-vulkan-drivers)
	$(BIN)/pytest -m 'viewer and not slow'

test-daemons: $(STAMP)  ## the tests that start a real SLURM (Debian's slurm-wlm, slurmdbd, munge, mariadb-server) or Ray
	$(BIN)/pytest -m daemons

check: $(STAMP)  ## style, types and import rules
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright
	$(BIN)/lint-imports

format: $(STAMP)  ## mend the style
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

bench: $(STAMP)  ## the benchmarks, one after the other
	set -e; for script in benchmarks/*.py; do echo "== $$script"; $(BIN)/python "$$script"; done

docs: $(DOCS)/.installed  ## the documentation, with plots and a link check, in build/docs/index.html
	$(DOCS)/bin/sphinx-build --quiet --fresh-env --fail-on-warning --keep-going --nitpicky docs build/docs
	@echo "build/docs/index.html"

$(DOCS)/.installed: pyproject.toml
ifdef UV
	@test -x $(DOCS)/bin/python || $(UV) venv --quiet --python '>=3.11' $(DOCS)
	$(UV) pip install --quiet --python $(DOCS)/bin/python --editable '.[docs]'
else
	@test -x $(DOCS)/bin/pip || $(PYTHON) -m venv $(DOCS)
	$(DOCS)/bin/pip install --quiet --editable '.[docs]'
endif
	@touch $@

RESOLVE := uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header
EXTRAS := box2d dev ray strangers train

lock: pyproject.toml  ## both locks for pyproject.toml, pins kept; UPGRADE=--upgrade resolves anew (needs uv)
	$(RESOLVE) $(UPGRADE) $(EXTRAS:%=--extra %) --output-file requirements.lock
	$(RESOLVE) --constraint requirements.lock --output-file requirements-compare.lock

clean:  ## caches and built packages; runs and .venv stay
	rm -rf build dist .pytest_cache .ruff_cache .import_linter_cache
	find . -name __pycache__ -type d -not -path './$(VENV)/*' -prune -exec rm -rf {} +
