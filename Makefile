# Everything a newcomer needs: `make run` shows the robot at work, `make test` shows that it is sound.
PYTHON ?= python3.11
BIN := .venv/bin
TASK ?= trees/pick_place.yaml
SEED ?= 0
WORLD ?= kinematic

.PHONY: run test test-all lint language-server clean

run: .venv/installed
	$(BIN)/frankie-task run $(TASK) --seed $(SEED) --world $(WORLD)

test: lint
	$(BIN)/pytest -n 2 -q

test-all: lint
	$(BIN)/pytest -n 2 -q -m "slow or not slow"

lint: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# What editors check task files with, for the tests of the schema; needs npm.
language-server: .venv/installed
	npm install --silent --no-audit --no-fund --prefix .venv/node yaml-language-server@1.25.0

.venv/installed: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]" --constraint constraints.txt
	touch $@

clean:
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis
