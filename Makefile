# Two commands do everything: `make demo` and `make test`. `make help` lists the rest.
SHELL := /bin/bash
VENV := .venv
BIN := $(CURDIR)/$(VENV)/bin
STAMPS := build/stamps
NATIVE := build/native
# What a person may set: PYTHON, CXX (compilers), CMAKE_FLAGS, TESTS (what pytest runs)
CMAKE_FLAGS ?=
TESTS ?= tests
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help setup native bpy50 demo test lint extension install-addon clean
.DEFAULT_GOAL := help

help:  ## this list
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

setup: $(STAMPS)/venv native  ## everything that the rest needs: packages, .venv, native module

$(STAMPS)/debian: tools/debian_packages.txt tools/install_debian_packages.sh
	@mkdir -p $(STAMPS)
	@tools/install_debian_packages.sh
	@touch $@

$(STAMPS)/venv: requirements.lock pyproject.toml tools/python.sh | $(STAMPS)/debian
	@python=$$(tools/python.sh) && echo "$(VENV): $$python" && \
	  { [ -x $(BIN)/python ] || "$$python" -m venv $(VENV); }
	$(BIN)/python -m pip install -q -r requirements.lock
	@# An editable install of the Python files: the module comes from `make native`.
	$(BIN)/python -m pip install -q --no-build-isolation --no-deps -e .
	@touch $@

# Ninja builds what has changed; the module and the OpenMP runtime are laid into isophote/.
native: $(STAMPS)/venv  ## the native module, after a change in native/ or kernels/
	@cxx=$$(tools/compiler.sh) && export PATH="$(BIN):$$PATH" && mkdir -p $(NATIVE) && \
	  if [ "$$(cat $(NATIVE)/configured 2> /dev/null)" != "$$cxx $(CMAKE_FLAGS)" ]; then \
	    rm -rf $(NATIVE) && mkdir -p $(NATIVE) && echo "Native module: $$cxx" && \
	    cmake -S . -B $(NATIVE) -G Ninja -DCMAKE_CXX_COMPILER="$$cxx" -DPython_EXECUTABLE=$(BIN)/python \
	      $(CMAKE_FLAGS) > $(NATIVE)/configure.log || { cat $(NATIVE)/configure.log; exit 1; }; \
	    echo "$$cxx $(CMAKE_FLAGS)" > $(NATIVE)/configured; \
	  fi && \
	  cmake --build $(NATIVE) --target install_native

# A second environment with the newest Blender that the add-on is tested with.
bpy50: $(STAMPS)/bpy50
$(STAMPS)/bpy50: requirements-bpy50.lock | $(STAMPS)/venv
	@if $(BIN)/python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))'; then \
	  { [ -x .venv-bpy50/bin/python ] || $(BIN)/python -m venv .venv-bpy50; } && \
	  .venv-bpy50/bin/python -m pip install -q -r requirements-bpy50.lock; \
	else echo "bpy 5.0 is for Python 3.11: its tests will be skipped"; fi
	@touch $@

demo: setup  ## render blend_scenes/cornell_box.blend and say where the picture is
	@$(BIN)/python tools/demo.py

test: setup bpy50 lint  ## everything that must pass
	@$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -m "not timed" $(TESTS) || [ $$? = 5 ]  # 5: none among TESTS
	@$(BIN)/python -m pytest -m timed $(TESTS) || [ $$? = 5 ]

lint: $(STAMPS)/venv  ## style of the Python files
	@$(BIN)/ruff check .

extension: setup  ## dist/: the zip for Blender 4.2 and newer, and the one for 3.4 to 4.1
	@$(BIN)/python tools/build_extension.py

install-addon: extension  ## into the Blender that is installed here
	@$(BIN)/python tools/install_addon.py

clean:  ## away with everything that was built; .venv stays
	rm -rf build dist isophote/_native*.so isophote/libomp*.so* isophote/libgomp*.so* isophote/kernels
