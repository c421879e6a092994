# Two commands: `make demo` and `make test`. Each makes its own virtual environment with pinned packages.
# While you work: `make check`, the quick part of `make test`. Now and then: `make campaign`, every blind case, and
# `make tutorials`, every tutorial and notebook. `make docs` builds the site, `make figures` draws its pictures.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
# Compiled modules are kept for the next process, also where the shell says otherwise: there are a thousand to compile.
PYTEST := env -u PYTHONDONTWRITEBYTECODE $(BIN)/python -m pytest
WORKERS := -n 2 --dist worksteal
LINT_LOG := build/lint.log

# Run pytest with the given words while ruff and mypy run beside it; fail where either does.
define pytest_beside_lint
	@mkdir -p $(dir $(LINT_LOG)); $(MAKE) --no-print-directory lint >$(LINT_LOG) 2>&1 & lint=$$!; \
	trap 'kill $$lint 2>/dev/null' INT TERM; \
	$(PYTEST) $(1); tests=$$?; \
	if wait $$lint; then echo "ruff and mypy found nothing"; else cat $(LINT_LOG); tests=1; fi; \
	exit $$tests
endef

.PHONY: demo test check campaign tutorials docs figures lint clean

demo: $(READY)
	$(BIN)/stillarm demo --out demo

test: $(READY)
	$(call pytest_beside_lint,$(WORKERS) -m "not realtime and not tutorial")
	$(PYTEST) -m realtime $$(grep -rl --include='test_*.py' 'pytest\.mark\.realtime' tests)

check: $(READY)
	$(call pytest_beside_lint,$(WORKERS) --quick)

campaign: $(READY)
	STILLARM_SLICE=all $(PYTEST) $(WORKERS) -m "blind and not realtime"
	STILLARM_SLICE=all $(PYTEST) -m "blind and realtime"

tutorials: $(READY)
	$(PYTEST) -m tutorial

docs: $(READY)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet
	@echo "site/index.html"

figures: $(READY)
	$(BIN)/python docs/figures

lint: $(READY)
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .
	$(BIN)/python -m mypy

$(READY): pyproject.toml requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "stillarm needs Python 3.11 or newer; name one: make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
		{ echo "the venv module is missing; install it (on Debian and Ubuntu: apt install python3-venv)"; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $(READY)

clean:
	rm -rf $(VENV) build *.egg-info .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
