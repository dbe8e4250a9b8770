# Everything happens in .venv, which is made anew whenever pyproject.toml changes.

PYTHON ?= $(shell for p in python3.11 python3.12 python3.10 python3.13 python3; do \
	$$p -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: help install demo test fast bench soak lint docs package clean

help:
	@echo "make demo   plan, simulate and verify examples/case_ii.yaml; results under out/"
	@echo "make test   all tests"
	@echo "make fast   tests without whole missions"
	@echo "make bench  measure planning, simulation, load sharing and navigation functions; results in out/benchmark_*.json"
	@echo "make soak   hours of malformed inputs, long runs, many runs; results in docs/soak.md"
	@echo "make lint   ruff"
	@echo "make docs   the documentation's site in out/site, notebooks run anew"
	@echo "make package  wheel and sdist in out/dist, installed and tried outside the checkout"
	@echo "make clean  remove .venv and out"

install: .venv/installed

.venv/installed: pyproject.toml
	@test -n "$(PYTHON)" || { echo "drake_ltl needs Python 3.10 to 3.13 on the path" >&2; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --editable '.[dev]'  # setuptools warns of our folders
	$(BIN)/python -m compileall -q drake_ltl diagrams models
	@touch $@

demo: install
	@mkdir -p out
	$(BIN)/drake-ltl simulate examples/case_ii.yaml --report out --record out/page.html --json out/verdict.json \
		--graphviz out/diagram.dot
	@echo "open out/page.html (the run) and out/report.html in a browser; figures are in out/figures, all data in out/*.npz and *.json"

test: install
	$(BIN)/pytest

fast: install
	$(BIN)/pytest -m "not mission"

bench: install
	$(BIN)/python benchmarks/planning.py
	$(BIN)/python benchmarks/simulation.py
	$(BIN)/python benchmarks/step_parts.py
	$(BIN)/python benchmarks/load_sharing.py
	$(BIN)/python benchmarks/navigation.py

soak: install
	$(BIN)/python benchmarks/soak.py

lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

docs: .venv/docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo "open out/site/index.html"

.venv/docs: .venv/installed
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --editable '.[docs]'
	@touch $@

package: install
	.ci/check_package $(BIN)/python

clean:
	rm -rf .venv out
