# `make demo` and `make test` need nothing but Python 3.11 or newer; they set everything up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo

.PHONY: demo test test-slow lint clean

demo: $(VENV)/.installed
	$(BIN)/synthdepth doctor
	$(BIN)/synthdepth render --map neighborhood --pairs 16 --pairs-per-scene 8 \
	    --pairs-per-flight 4 --burst-pairs 2 --out $(DEMO)/neighborhood
	$(BIN)/synthdepth verify $(DEMO)/neighborhood
	$(BIN)/synthdepth preview $(DEMO)/neighborhood --out $(DEMO)/preview.png --count 16
	@echo "the pairs are in $(CURDIR)/$(DEMO)/neighborhood, a contact sheet in $(CURDIR)/$(DEMO)/preview.png"

test: lint
	$(BIN)/pytest -m "not slow" -n 2 --dist loadfile --durations=8

test-slow: $(VENV)/.installed
	$(BIN)/pytest -m slow --durations=8

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "$(PYTHON) is too old: synthdepth needs Python 3.11 or newer (make PYTHON=python3.12)"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) $(DEMO) build dist .pytest_cache .ruff_cache
