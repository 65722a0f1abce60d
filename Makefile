# make paper, make test: from nothing but Python and make. The environment lives in .venv.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: help paper test lint bench clean
help:
	@echo "make paper   the paper's figures, data and claims, in paper/"
	@echo "make test    all tests"
	@echo "make lint    style, types, layers"
	@echo "make bench   speed, start-up and memory, the ratios to Mesa and to a plain numba loop, the live arena"

paper: $(VENV)/installed
	$(BIN)/feasibee paper --out paper

test: $(VENV)/with-test
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal

lint: $(VENV)/with-lint
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/with-bench
	$(BIN)/python benchmarks/bench.py
	$(BIN)/python benchmarks/live.py

clean:
	rm -rf $(VENV) paper

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/with-%: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --group $*
	@touch $@
