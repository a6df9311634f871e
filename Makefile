# Two commands do everything on a fresh machine: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: setup demo test lint stress bench format

setup: .venv/ready

.venv/ready: requirements.lock pyproject.toml .ci/setup
	PYTHON="$(PYTHON)" sh .ci/setup
	touch $@

demo: setup
	$(BIN)/brdf demo --output demo --force

test: setup
	$(BIN)/python -m pytest -q -n auto --dist worksteal

lint: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/basedpyright

stress: setup
	$(BIN)/brdf stress

bench: setup
	$(BIN)/brdf bench fit $(BENCH)

format: setup
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
