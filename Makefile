# Each target makes .venv in this folder if it is not there, installs what it needs, and runs.
#   make demo              PYTHON=python3.12 make test              make test ARGS="-k tsda"
PYTHON ?= python3
ARGS   ?=

.PHONY: install demo quick test slow others robots bridges cluster browser dist wheel check docs format clean
.NOTPARALLEL:

install demo quick test slow others robots bridges cluster browser dist wheel check docs format clean:
	@$(PYTHON) dev.py $@ $(ARGS)
