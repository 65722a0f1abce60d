# make paper, make test, make docs: from nothing but Python and make. The environment lives in .venv.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
LOWEST ?= .venv-lowest
LOWEST_PYTHON ?= python3.11
ROS ?= .venv-ros
ROS_PYTHON ?= python3.11

.PHONY: help paper test test-all test-lowest test-ros coverage lint lint-js format-js engine wheels wasm bench sizes docs claims claims-short clean
help:
	@echo "make paper   the paper's figures, data and claims, in paper/, as docs/paper.md has them: 2,000 swarms at each ratio, seed 1"
	@echo "make test    the tests that take minutes together; ROOM=engine those of one folder in tests/"
	@echo "make test-all    the slow ones, too"
	@echo "make test-lowest   those of make test that need packages, with the lowest versions that pyproject.toml states, of"
	@echo "             Python too; in $(LOWEST)"
	@echo "make test-ros   the nodes of ROS 2 and their types, in $(ROS), whose wheels are for Python 3.11"
	@echo "make coverage   make test, and which lines of Python in the package it runs"
	@echo "make lint    style, types, layers, workflows, citation, and whether the house has grown (tests/size.py)"
	@echo "make lint-js format and types of the pages' JavaScript, with npm; make format-js formats it"
	@echo "make engine  the engine, compiled from C into src/feasibee/engine/lib, unless it is there; make test does it, too"
	@echo "make wheels  the package for Linux, macOS and Windows, and its sources, in dist/; all from this machine"
	@echo "make wasm    the engine of pages, compiled from C into src/feasibee/engine/lib/feasibee.wasm"
	@echo "make bench   speed, threads, start-up and memory, as ratios to other programs, and the live arena; QUICK=1 takes a"
	@echo "             minute, SAVE=1 keeps the figures for docs/speed.md, AGAINST=../other/src compares two versions"
	@echo "make sizes   flash and RAM of the C controller for each strategy and processor with a compiler here"
	@echo "make docs    the documentation, in docs/_build/html; runs the gallery's examples"
	@echo "make claims  the numbers of the documentation, computed again and put right; CHECK=1 only reports, PAGE=paper"
	@echo "make claims-short   a minute of it: the quick ones computed, all others found on their page"

paper: $(VENV)/installed
	$(BIN)/feasibee paper --runs 2000 --seed 1 --out paper

test: $(VENV)/with-test
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal $(ROOM:%=tests/%)

# A test that hangs ends with a traceback, and not with the patience of whoever waits for all of them.
test-all: $(VENV)/with-test $(VENV)/with-recipes
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal -m "" --durations 25 \
		-o faulthandler_timeout=600 -o faulthandler_exit_on_timeout=true

# Rooms whose code calls packages: pydantic, click, rich, Jinja, NumPy, SciPy, pandas, xarray, h5netcdf, matplotlib, pillow,
# cffi, PyYAML, tomli-w and platformdirs. Left out is what no version of them changes: the model, which the engine and the
# reference compute without packages, robots in C, processes and their signals, pages, and the texts of docs.
CALLING := src tests/base tests/engine/test_library.py tests/field/test_recording.py tests/field/test_senses.py \
	tests/figures tests/live/test_catalogue.py tests/live/test_serve.py tests/results tests/scenario tests/studies \
	tests/theory tests/test_errors.py tests/test_requirements.py $(addprefix tests/cli/test_,$(addsuffix .py, \
	commands hostile listings predict_command reproduce)) $(addprefix tests/simulation/test_,$(addsuffix .py, \
	changing_sweeps declared_sweeps inspection kept lowering plan public same_bytes store sweep))

# Old versions warn of what new ones, brought along by others, no longer want.
test-lowest: $(LOWEST)/installed
	$(LOWEST)/bin/python -m pytest --numprocesses auto --dist worksteal -W ignore::DeprecationWarning \
		-m "not slow and not browser" $(CALLING)

# One worker: nodes with clocks of their own need the processors.
test-ros: $(ROS)/installed
	cd ros2 && ../$(ROS)/bin/python -m mypy
	cd ros2 && ../$(ROS)/bin/python -m pytest -m ""

# What ran is reported after failures, too: tests of time may fail, since every line is counted.
coverage: $(VENV)/with-test
	$(BIN)/coverage run -m pytest --numprocesses auto --dist worksteal; status=$$?; \
		$(BIN)/coverage combine --quiet; $(BIN)/coverage report && exit $$status

lint: $(VENV)/with-lint
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/mypy research/*.py
	$(BIN)/lint-imports
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/python tests/size.py

lint-js: node_modules/installed
	npm run --silent lint

format-js: node_modules/installed
	npm run --silent format

engine: $(VENV)/installed
	$(BIN)/python -m feasibee.engine.build

wheels: $(VENV)/with-wheels
	for platform in $$($(BIN)/python -c "from feasibee.engine.platforms import PLATFORMS; print(*PLATFORMS)"); do \
		FEASIBEE_PLATFORM=$$platform $(BIN)/python -m hatchling build --target wheel || exit; \
	done
	$(BIN)/python -m hatchling build --target sdist

wasm: $(VENV)/with-wasm
	$(BIN)/python -m feasibee.engine.build --wasm

bench: $(VENV)/with-bench
	$(BIN)/python benchmarks/bench.py $(if $(QUICK),--quick) $(if $(SAVE),--save) $(if $(AGAINST),--against $(AGAINST))
	$(if $(QUICK)$(AGAINST),,$(BIN)/python benchmarks/live.py)
	$(if $(SAVE),$(BIN)/python -m claims --short speed readme)

sizes: $(VENV)/with-bench $(VENV)/with-wasm
	$(BIN)/python benchmarks/sizes.py

docs: $(VENV)/with-docs
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -d docs/_build/doctrees docs docs/_build/html
	@echo "The documentation is docs/_build/html/index.html"

claims: $(VENV)/with-bench $(VENV)/with-test $(VENV)/with-wasm $(ROS)/installed
	$(BIN)/python -m claims $(PAGE) $(if $(CHECK),--check)

claims-short: $(VENV)/installed
	$(BIN)/python -m claims --check --short $(PAGE)

clean:
	rm -rf $(VENV) $(LOWEST) $(ROS) build dist src/feasibee/engine/lib paper docs/_build docs/gallery docs/made .claims

node_modules/installed: package-lock.json
	npm ci --silent --no-audit --no-fund
	@touch $@

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

# pip has no lowest versions: uv chooses and installs them.
$(LOWEST)/installed: pyproject.toml
	$(LOWEST_PYTHON) -m venv --clear $(LOWEST)
	$(LOWEST)/bin/python -m pip install --quiet uv
	$(LOWEST)/bin/uv pip install --quiet --python $(LOWEST)/bin/python --resolution lowest-direct \
		--requirements pyproject.toml --all-extras --group test
	$(LOWEST)/bin/uv pip install --quiet --python $(LOWEST)/bin/python --no-deps --editable .
	@touch $@

# Not in the usual environment: the wheels bring modules of general names, such as em.
$(ROS)/installed: pyproject.toml ros2/setup.py
	$(ROS_PYTHON) -m venv --clear $(ROS)
	$(ROS)/bin/python -m pip install --quiet --upgrade pip
	$(ROS)/bin/python -m pip install --quiet --editable . --editable './ros2[wheels,test]'
	@touch $@

$(VENV)/with-%: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --group $*
	@touch $@
