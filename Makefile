# Everything sets itself up: a virtual environment in .venv, then the package in editable mode.

PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

PYTEST := $(BIN)/python -m pytest -q --numprocesses 2 --dist worksteal

.PHONY: demo train test test-all demo-check wheel check docs bench reproduce clean

# `pip install .` in .venv would put a copy of the tree there, which hides it: then install again.
ifeq (,$(wildcard .venv/lib/python3*/site-packages/__editable__.activesuit-*))
.PHONY: .venv/core .venv/train .venv/docs .venv/dev .venv/gpu
endif

demo: .venv/core
	$(BIN)/activesuit demo --out runs/demo

train: .venv/train
	@echo 'Ready: $(BIN)/activesuit train --algo ppo --steps 200000 --out runs/ppo'

# Sixty processes of the tests import the package, and would compile it each without bytecode.
test test-all: export PYTHONDONTWRITEBYTECODE =
test: .venv/dev
	$(PYTEST) -m "not slow"

test-all: .venv/dev .venv/docs .venv/gpu
	$(PYTEST) --durations 10
	$(MAKE) reproduce demo-check

# The demo of the wheel, in an empty environment, has the numbers that README and docs report.
demo-check: .venv/dev
	rm -rf build/demo && mkdir -p build/demo && $(MAKE) wheel WHEEL=$(CURDIR)/build/demo
	cd build/demo && venv/bin/activesuit demo --out run --trials 3
	$(BIN)/python -m activesuit.tools.measure --check demo build/demo/run

# A wheel and a new environment with nothing but the wheel, in the folder WHEEL.
wheel: .venv/dev
	$(BIN)/python -m build --outdir $(WHEEL)/dist . >$(WHEEL)/build.log 2>&1 || { cat $(WHEEL)/build.log; exit 1; }
	$(PYTHON) -m venv $(WHEEL)/venv
	$(WHEEL)/venv/bin/pip install --quiet --disable-pip-version-check -c constraints.txt $(WHEEL)/dist/*.whl

check: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

docs: .venv/docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

bench: .venv/core
	$(BIN)/python -m activesuit.benchmarks $(TOPIC)

# Few trials; without these options each program repeats its paper whole.
reproduce: .venv/core
	$(BIN)/python -m activesuit.reproductions.li_2022 --trials 10
	$(BIN)/python -m activesuit.reproductions.kao_fung_2009 --trials 10 --population 2000
	$(BIN)/python -m activesuit.reproductions.noel_schoukens_2016

clean:
	rm -rf build dist site *.egg-info .pytest_cache .ruff_cache .hypothesis
	find . -path ./.venv -prune -o -name __pycache__ -exec rm -rf {} +

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("ActiveSuit needs Python 3.11 or newer; give it as: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv .venv

.venv/core: pyproject.toml constraints.txt | .venv/bin/python
	$(PIP) -e .
	touch $@

.venv/train: pyproject.toml constraints.txt | .venv/bin/python
	$(PIP) -e '.[train]'
	touch $@

.venv/docs: pyproject.toml constraints.txt | .venv/bin/python
	$(PIP) -e '.[docs]'
	touch $@

.venv/dev: pyproject.toml constraints.txt | .venv/bin/python
	$(PIP) -e '.[train,onnx,cluster,video,muscles,dev]'
	touch $@

.venv/gpu: pyproject.toml constraints.txt | .venv/bin/python
	$(PIP) -e '.[gpu]'
	touch $@
