# Everything runs from .venv, which the first target that needs it makes from requirements.lock.
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
UV := $(shell command -v uv 2>/dev/null)
PYTHON ?= python3

.DEFAULT_GOAL := help
.PHONY: help install demo test test-slow test-daemons check format bench lock clean

help:  ## what can be made
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-13s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(STAMP)  ## .venv with the locked libraries and dr_lab

$(STAMP): requirements.lock pyproject.toml
ifdef UV
	@test -x $(BIN)/python || $(UV) venv --quiet --python '>=3.11' $(VENV)
	$(UV) pip install --quiet --python $(BIN)/python --require-hashes -r requirements.lock
	$(UV) pip install --quiet --python $(BIN)/python --no-deps --editable .
else
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "dr_lab needs Python 3.11 or newer: make PYTHON=…")'
	@test -x $(BIN)/pip || $(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --require-hashes -r requirements.lock
	$(BIN)/pip install --quiet --no-deps --editable .
endif
	@touch $@

demo: $(STAMP)  ## find what the Furuta pendulum's model lacks, add it, and print the ladder
	$(BIN)/dr-lab close model=furuta measurements=furuta
	@echo
	@echo "To type dr-lab yourself: . $(BIN)/activate"

test: $(STAMP)  ## the tests, without those that take minutes or need daemons
	$(BIN)/pytest --numprocesses auto --dist loadfile

test-slow: $(STAMP)  ## the tests that take minutes
	$(BIN)/pytest -m slow

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

lock: pyproject.toml  ## requirements.lock for pyproject.toml, pins kept; UPGRADE=--upgrade resolves anew (needs uv)
	uv pip compile pyproject.toml --quiet --extra box2d --extra dev --extra ray --extra strangers --universal --python-version 3.11 $(UPGRADE) \
		--generate-hashes --no-emit-index-url --no-header --output-file requirements.lock

clean:  ## caches and built packages; runs and .venv stay
	rm -rf build dist .pytest_cache .ruff_cache .import_linter_cache
	find . -name __pycache__ -type d -not -path './$(VENV)/*' -prune -exec rm -rf {} +
