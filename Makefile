PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
JOBS ?= 2

.PHONY: run test slow js long lint docs bench clean

run: $(VENV)/installed
	$(BIN)/rmfs run scenarios/paper-250.toml

test: $(VENV)/installed-dev
	$(BIN)/python -m pytest -m "not slow" -n $(JOBS) --dist worksteal

slow: $(VENV)/installed-dev
	$(BIN)/python -m pytest -m slow -n $(JOBS) --dist loadfile

# The JavaScript of the page that `rmfs replay` writes; node's own test runner, nothing of npm.
js:
	node --test tests/plugins/rmfs_commands/replay/view/*.test.mjs

# What takes too long for every change: done before a release.
long: $(VENV)/installed-dev
	$(BIN)/python tools/coverage_study.py
	$(BIN)/python tools/fuzz.py --seed 2 --cases 20000
	$(BIN)/python tools/random_worlds.py --worlds 3000
	$(BIN)/python tools/soak.py
	$(BIN)/python -m pytest tests/benchmarks/test_multi_day.py --benchmark-enable
	$(BIN)/python tools/pages.py --long docs/how-to/train-a-policy.md
	$(BIN)/python tools/load.py
	$(BIN)/python -m pytest -m hypothesis -n $(JOBS) --hypothesis-profile=explore

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/installed-docs
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "Open docs/_build/html/index.html"

bench: $(VENV)/installed-dev
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

clean:
	rm -rf $(VENV) build dist docs/_build docs/reference/_generated .pytest_cache .mypy_cache .ruff_cache \
	  .import_linter_cache
	find rmfs_core plugins tests tools -name __pycache__ -prune -exec rm -rf {} +
