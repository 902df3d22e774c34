# The commands of the house; `make help` lists them. Everything is installed into $(VENV) first,
# and again only when pyproject.toml or constraints.txt changes.
#
#   make PYTHON=python3.12 …   another interpreter (3.11 or later)
#   make VENV=/some/folder …   another place for the virtual environment

PYTHON  ?= python3
VENV    ?= .venv
SPEC    ?= specs/flatworld_cycle.yaml
WORKERS ?= 2

BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
RIVALS := $(VENV)/.rivals
PYTEST := $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -ra --durations=10

.DELETE_ON_ERROR:
.PHONY: help setup run records results sheet experts bench test quick check format constraints clean

help:  ## list the commands
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-12s %s\n", $$1, $$2 }' Makefile

setup: $(STAMP)  ## make the virtual environment and install everything, pinned

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "tiloilc needs Python 3.11 or later: make PYTHON=python3.11 …" >&2; exit 1; }
	$(BIN)/python -c '' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
	  --constraint constraints.txt --editable '.[tensorboard,dev]'
	@touch $@

run: $(STAMP)  ## the main job: compile, train, evaluate and report SPEC (FlatWorld Cycle)
	$(BIN)/tiloilc run $(SPEC)

records: $(STAMP)  ## train the tasks of specs/ that are not recorded yet; records in results/
	$(BIN)/tiloilc sweep specs/*.yaml

results: $(STAMP)  ## write docs/results/, README's table and figure, docs/pendulum.md from records
	$(BIN)/python -m tiloilc.report.results
	$(BIN)/python -m tiloilc.bench.pendulum results/sac/pendulum.jsonl.gz docs/pendulum.md

sheet: $(STAMP)  ## draw every task of specs/ with a demonstration: docs/tasks.png
	$(BIN)/tiloilc viz --env specs/*.yaml -o docs/tasks.png

experts: $(STAMP)  ## play every task of specs/ with its expert: docs/tasks.md
	$(BIN)/python -m tiloilc.bench.experts docs/tasks.md

bench: $(RIVALS)  ## measure everything beside others; docs/benchmarks.md, docs/automaton_sizes.md
	$(BIN)/tiloilc bench -o docs

$(RIVALS): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
	  --constraint constraints.txt --editable '.[tensorboard,dev,bench,mujoco]'
	@touch $@

test: $(STAMP)  ## all tests, the slow ones too
	$(PYTEST)

quick: $(STAMP)  ## the tests of every day: all but the slow ones
	$(PYTEST) -m "not slow"

check: $(STAMP)  ## format, lint, types, imports
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(STAMP)  ## put every file into the one format, and mend what can be mended
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

constraints:  ## resolve every dependency afresh and write constraints.txt
	$(PYTHON) -m venv --clear build/resolve
	build/resolve/bin/python -m pip install --quiet "$$(grep '^torch==' constraints.txt)" \
	  --editable '.[all,bench,dev]'
	{ grep '^#' constraints.txt; build/resolve/bin/python -m pip freeze --all --exclude pip \
	  --exclude-editable | sed 's/+.*//'; } > build/constraints.txt
	mv build/constraints.txt constraints.txt
	rm -rf build/resolve

clean:  ## remove what was built, not what was trained
	rm -rf build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
