# Everything a person does with the project. Each target does all the set-up it needs, inside the tree.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
BUILD_JOBS ?= 2
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(BUILD_JOBS)
export PATH := $(abspath $(BIN)):$(PATH)

SOURCES := $(shell find firmware core cmake CMakeLists.txt pyproject.toml -type f 2>/dev/null)
C_FILES := $(shell find firmware core tests -name '*.[ch]' -o -name '*.[ch]pp')

.PHONY: help demo test lint format bench fuzz test-asan docs lock clean

help:  ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 14

$(VENV)/deps.stamp: requirements.lock
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv==0.13.8
	$(BIN)/uv pip install --quiet --python $(BIN)/python --require-hashes -r requirements.lock
	touch $@

$(VENV)/build.stamp: $(VENV)/deps.stamp $(SOURCES)
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-build-isolation --no-deps --editable .
	touch $@

build: $(VENV)/build.stamp  ## the virtual environment and the compiled core

demo: build  ## a skinned UR5 in the browser
	$(BIN)/robotskin demo

test: build  ## every test
	$(BIN)/python -m pytest

lint: $(VENV)/deps.stamp  ## formatters and linters of the three languages
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run --Werror $(C_FILES)
	$(BIN)/mypy

format: $(VENV)/deps.stamp  ## rewrite the sources in the house format
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format --quiet .
	$(BIN)/clang-format -i $(C_FILES)

clean:  ## remove what was built
	rm -rf build $(VENV)/build.stamp
