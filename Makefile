# SPDX-License-Identifier: Apache-2.0
# Everything a person does with the project. Each target does all the set-up it needs, inside the tree.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
BUILD_JOBS ?= 2
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(BUILD_JOBS)
export PATH := $(abspath $(BIN)):$(PATH)
# Where compiled modules are not kept, each of the hundreds of programs that tests start compiles a thousand of them anew.
unexport PYTHONDONTWRITEBYTECODE

SOURCES := $(shell find firmware core lab/core cmake CMakeLists.txt pyproject.toml -type f 2>/dev/null)
C_FILES := $(shell find firmware core lab tests examples -name '*.[ch]' -o -name '*.[ch]pp')

.PHONY: help build emulator demo test test-asan soak fuzz lint format bench docs stubs lock clean

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

emulator:  ## the emulator of a Raspberry Pi Pico, for its tests and bench (needs Node)
	npm ci --silent --prefix lab/rp2040

demo: build  ## a skinned UR5 in the browser
	$(BIN)/robotskin demo

test: build  ## every test
	$(BIN)/python -m pytest -n $(BUILD_JOBS) --dist worksteal

test-asan: $(VENV)/deps.stamp  ## the C and C++ checks under AddressSanitizer, UBSan and ThreadSanitizer
	$(BIN)/python -m pytest tests/core/test_native.py

SECONDS ?= 600
soak: build  ## the fault campaign on new seeds, then the largest model checks, SECONDS=600
	$(BIN)/python -m robotskin_lab.campaign --soak $(SECONDS)
	$(BIN)/python -m robotskin_lab.campaign --model

FUZZ_SECONDS ?= 60
CLANGXX ?= $(shell command -v clang++ || ls -v /usr/bin/clang++-* 2>/dev/null | tail -1)
fuzz: $(VENV)/deps.stamp  ## coverage-guided fuzzing of the driver (needs clang), FUZZ_SECONDS=60
	@test -n "$(CLANGXX)" || { echo "make fuzz needs clang with libFuzzer: neither clang++ nor /usr/bin/clang++-NN is here"; exit 1; }
	cmake -G Ninja -S tests/core -B build/native/fuzz -DFUZZ=ON -DSANITIZE=address,undefined \
	  -DCMAKE_CXX_COMPILER=$(CLANGXX) -DCMAKE_C_COMPILER=$(subst clang++,clang,$(CLANGXX)) \
	  -DBOOST_INCLUDE=$$($(BIN)/python -c "import sysconfig; print(sysconfig.get_path('purelib'))")/cmeel.prefix/include
	cmake --build build/native/fuzz --target fuzz_driver
	mkdir -p build/native/corpus
	build/native/fuzz/fuzz_driver -max_total_time=$(FUZZ_SECONDS) -max_len=4096 build/native/corpus

lint: $(VENV)/deps.stamp  ## formatters and linters of the three languages
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@$(BIN)/clang-format --dry-run --Werror $(C_FILES)
	$(BIN)/mypy

format: $(VENV)/deps.stamp  ## rewrite the sources in the house format
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format --quiet .
	@$(BIN)/clang-format -i $(C_FILES)

bench: build  ## every benchmark, as JSON under out/bench
	$(BIN)/robotskin bench all --directory out/bench

docs: build  ## rewrite the generated tables of the pages, then all pages and the reference as HTML in build/docs
	$(BIN)/python docs/protocol_tables.py
	$(BIN)/python docs/fault_table.py
	$(BIN)/python docs/mechanism_table.py
	$(BIN)/python docs/imperfection_table.py
	$(BIN)/python docs/equation_table.py
	$(BIN)/python docs/architecture_drawing.py
	$(BIN)/python -m sphinx -q -b html docs build/docs

stubs: build  ## rewrite the type stubs of the compiled core
	$(BIN)/python core/bindings/stubs.py

lock: $(VENV)/deps.stamp  ## pin every dependency, with hashes, after a change of pyproject.toml
	(echo '# Written by `make lock` from pyproject.toml; every version and hash is fixed here.'; \
	 $(BIN)/uv pip compile pyproject.toml --extra models --extra docs --group dev --generate-hashes --no-emit-index-url --no-annotate --no-header --quiet) > requirements.lock.new
	mv requirements.lock.new requirements.lock

clean:  ## remove what was built
	rm -rf build $(VENV)/build.stamp
