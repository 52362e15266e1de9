PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
JOBS ?= 2
LOWEST := $(VENV)-lowest
LOWEST_PYTHON ?= python3.11

.PHONY: help run test slow js long lowest release-check lint docs bench clean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-14s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

run: $(VENV)/installed  ## simulate the paper's 250 orders
	$(BIN)/rmfs run scenarios/paper-250.toml

test: $(VENV)/installed-dev  ## the tests that take seconds
	$(BIN)/python -m pytest -m "not slow" -n $(JOBS) --dist worksteal

slow: $(VENV)/installed-dev  ## the tests that take longer; they need Chromium
	$(BIN)/python -m pytest -m slow -n $(JOBS) --dist loadfile

# The JavaScript of the page that `rmfs replay` writes: its types, by a compiler that npx fetches once, and its tests, by
# node's own runner.
js:  ## types and tests of the JavaScript in the page of `rmfs replay`; they need node 18 or newer, and npm
	npx --yes --package typescript@6.0.3 tsc --project plugins/rmfs_commands/replay/view/jsconfig.json
	node --test tests/plugins/rmfs_commands/replay/view/*.test.mjs

# What takes too long for every change: done before a release.
long: $(VENV)/installed-dev lowest  ## studies that take minutes to hours, before a release
	$(BIN)/python tools/coverage_study.py
	$(BIN)/python tools/fuzz.py --seed 2 --cases 20000
	$(BIN)/python tools/random_worlds.py --worlds 3000
	$(BIN)/python tools/random_worlds.py --failures --worlds 3000
	$(BIN)/python tools/soak.py
	$(BIN)/python -m pytest tests/benchmarks/test_multi_day.py --benchmark-enable
	$(BIN)/python tools/pages.py --long docs/how-to/train-a-policy.md docs/how-to/judge-a-policy.md
	$(BIN)/python tools/load.py
	$(BIN)/python -m pytest -m hypothesis -n $(JOBS) --hypothesis-profile=explore

# The lower bounds of pyproject.toml, in an environment of their own. Old libraries may warn of each other: no error here.
lowest:  ## the tests that take seconds, with the lowest versions that pyproject.toml allows
	rm -rf $(LOWEST)
	$(LOWEST_PYTHON) -m venv $(LOWEST)
	$(LOWEST)/bin/python tools/lowest.py > $(LOWEST)/constraints.txt
	$(LOWEST)/bin/python -m pip install --quiet --constraint $(LOWEST)/constraints.txt -e ".[test]"
	$(LOWEST)/bin/python -m pytest -m "not slow" -n $(JOBS) --dist worksteal -W default tests/rmfs_core tests/plugins

release-check: $(VENV)/installed-dev  ## sdist and wheel in dist/, what an index says of them, and the wheel on its own
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python -m twine check --strict dist/*
	$(BIN)/python tools/try_wheel.py dist/*.whl

lint: $(VENV)/installed-dev  ## ruff (rules and format), mypy, import-linter, codespell
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell README.md CONTRIBUTING.md SECURITY.md CHANGELOG.md docs rmfs_core plugins tools scenarios

docs: $(VENV)/installed-docs  ## the documentation, warnings as errors
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "Open docs/_build/html/index.html"

bench: $(VENV)/installed-dev  ## the benchmarks; OPTIONS are pytest's
	$(BIN)/python -m pytest tests/benchmarks --benchmark-enable --benchmark-only $(OPTIONS)

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: pyproject.toml $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet -e .
	touch $@

$(VENV)/installed-dev: pyproject.toml $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet -e ".[test,lint]"
	touch $@ $(VENV)/installed

$(VENV)/installed-docs: pyproject.toml $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet -e ".[docs]"
	touch $@ $(VENV)/installed

clean:  ## remove the environments and everything made
	rm -rf $(VENV) $(LOWEST) build dist docs/_build docs/reference/_generated .pytest_cache .mypy_cache .ruff_cache \
	  .import_linter_cache
	find rmfs_core plugins tests tools -name __pycache__ -prune -exec rm -rf {} +
