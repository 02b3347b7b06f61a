# Everything a newcomer needs: `make run` shows the robot at work, `make test` shows that it is sound.
# PYTHON=/path/to/python chooses a Python; without it install.sh finds one of 3.11 to 3.14.
PYTHON ?=
BIN := .venv/bin
TASK ?= trees/pick_place.yaml
SEED ?= 0
WORLD ?= kinematic

.PHONY: run test test-slow test-all coverage lint system experiments film clean

run: .venv/installed
	@$(BIN)/frankie-task run $(TASK) --seed $(SEED) --world $(WORLD)

# Two processes, each on one core, of which one takes over what the other has not begun. Byte code is
# written though the environment forbid it: tests start many programs, and each would compile it all.
PYTEST := OMP_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= $(BIN)/pytest --dist worksteal -q

test: lint
	$(PYTEST) -n 2

# What keeps real time has the computer to itself.
test-slow: .venv/developing
	$(PYTEST) -n 2 -m "slow and not realtime"
	$(PYTEST) -n 0 -m "slow and realtime"

test-all: test test-slow

# The share of the statements that any test runs, child processes included; room by room, then all.
ROOMS := app behaviours config controller drivers extensions hw lab perception robots trees
coverage: .venv/developing
	$(BIN)/coverage erase
	OMP_NUM_THREADS=1 $(BIN)/coverage run -m pytest -q -n 2 -m "slow or not slow"
	$(BIN)/coverage combine -q
	@for room in $(ROOMS); do echo "$$room $$($(BIN)/coverage report --format=total --include="$$room/*")"; done
	$(BIN)/coverage report --format=total --fail-under=95

lint: .venv/developing
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --num-workers 2

# What some tests need from a Debian or Ubuntu system, as root: a page's browser, a viewer's Vulkan,
# the camera's USB, and strace to see who is called. Tests are skipped without it.
SYSTEM := chromium libusb-1.0-0 mesa-vulkan-drivers strace
system:
	dpkg -s $(SYSTEM) >/dev/null 2>&1 || { apt-get update -qq && apt-get install -y -qq $(SYSTEM); }

# Every figure of docs/experiments.md that takes less than an hour together, and what has changed.
experiments: .venv/developing
	$(BIN)/frankie-task bench experiments

# The moving picture of the README; needs a Vulkan driver (Debian: mesa-vulkan-drivers).
film: .venv/installed
	$(BIN)/frankie-task run trees/pick_place.yaml --seed 0 --view none
	$(BIN)/frankie-task film last docs/images/pick_place.webp --from 3.5 --to 18.5

.venv/installed: pyproject.toml constraints.txt
	@PYTHON="$(PYTHON)" ./install.sh

.venv/developing: pyproject.toml constraints.txt
	@PYTHON="$(PYTHON)" ./install.sh dev

clean:
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis
