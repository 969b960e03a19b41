# SPDX-License-Identifier: GPL-3.0-or-later
.DEFAULT_GOAL := help
.PHONY: help demo report bench test setup setup-run plugin plugin-gui install-gui gui-root docs-pictures \
	test-style test-engine test-sanitize test-race fuzz test-plugin test-python test-gui test-hosts

# Targets share build folders, and builds and tests use all cores anyway.
.NOTPARALLEL:

# Not PYTHON: that names the interpreter of which scripts/setup.sh makes .venv.
VENV_PYTHON := .venv/bin/python
JOBS ?= $(shell nproc)
GUI_ROOT := $(or $(SPHEROSEG_GUI_ROOT),$(CURDIR)/.cache/meshlab-root)
CPP_FILES = $(shell git ls-files 'filter_spheroseg/*.h' 'filter_spheroseg/*.cpp' 'filter_spheroseg/*.cu' \
	'filter_spheroseg/*.cuh' 'tests/*.h' 'tests/*.cpp' 'tools/*.h' 'tools/*.cpp')
export PYTHONPATH := $(CURDIR)/python
export CCACHE_DIR ?= $(CURDIR)/.cache/ccache
# Where bytecode must not be written, each of hundreds of processes compiles what it imports.
export PYTHONDONTWRITEBYTECODE :=

help:
	@echo "make demo        set up, build, segment a mesh and make a picture of it (out/demo)"
	@echo "make report      compare with METIS and region growing (out/report/report.html)"
	@echo "make bench       time and quality against partitioners (out/bench; some 20 minutes)"
	@echo "make test        everything that CI runs"
	@echo "make fuzz        fuzzing of the engine (docs/reliability.md)"
	@echo "make plugin      the plugin for PyMeshLab: build/plugin/libfilter_spheroseg.so"
	@echo "make plugin-gui  the plugin for the MeshLab application: build/gui"
	@echo "make install-gui adds it to the MeshLab application of this user"
	@echo "make test-gui    tests it in the real MeshLab window, on a virtual screen"
	@echo "make test-hosts  the same plugin in earlier releases of PyMeshLab"
	@echo "make docs-pictures  the screenshots of docs/meshlab.md, taken anew"
	@echo "make setup       what building and testing need: packages, .venv, headers"

setup:
	@scripts/setup.sh dev

setup-run:
	@scripts/setup.sh run

plugin: setup-run
	cmake --preset plugin $(WARNINGS)
	cmake --build build/plugin --parallel $(JOBS)

# Where the application of the GUI tests is at hand, the linker checks that it brings all symbols.
plugin-gui: setup-run
	cmake --preset gui $(WARNINGS) \
		-DSPHEROSEG_MESHLAB_COMMON="$$(ls "$(GUI_ROOT)"/usr/lib/*/meshlab/libmeshlab-common.so 2>/dev/null)"
	cmake --build build/gui --parallel $(JOBS)

install-gui: plugin-gui
	$(VENV_PYTHON) -m spheroseg install-plugin $(INSTALL_ARGUMENTS)

gui-root:
	@SPHEROSEG_GUI_ROOT="$(GUI_ROOT)" scripts/setup.sh gui

demo: plugin
	$(VENV_PYTHON) -m spheroseg.demo out/demo

# PyMeshLab's samples and ours; with REPORT_MESHES, a folder, also what is in there.
REPORT_MESHES ?= $(wildcard ../shared/meshes)
report: setup plugin
	$(VENV_PYTHON) -m spheroseg evaluate sample_meshes $(REPORT_MESHES) \
		$(addprefix $(shell $(VENV_PYTHON) -c 'import pymeshlab; print(pymeshlab.__path__[0])')/tests/sample_meshes/,\
			cow.obj airplane.obj bone.ply bunny.obj) \
		-o out/report -k 20 200

# BENCH holds options, as in: make bench BENCH="--meshes cow,bunny --k 200" (see --help).
# docs/benchmarks.md is written anew once there is a sweep, too: make bench BENCH=--validity-sweep
bench: setup plugin
	$(VENV_PYTHON) -m spheroseg.bench $(BENCH)

# In tests warnings are errors. In all builds, as objects are shared between equal options only.
test test-gui: WARNINGS := -DSPHEROSEG_WERROR=ON

# All that is downloaded first, at once.
test: gui-root test-style test-engine test-sanitize test-race test-plugin test-python test-gui

test-style: setup
	.venv/bin/clang-format --dry-run -Werror $(CPP_FILES)
	.venv/bin/ruff check
	.venv/bin/ruff format --check

# Where nvcc is, with the GPU engine (docs/gpu.md); the other builds have its stand-in.
test-engine: setup
	cmake --preset engine -DSPHEROSEG_WERROR=ON -DSPHEROSEG_BUILD_TOOLS=ON \
		-DSPHEROSEG_CUDA=$(if $(shell command -v nvcc),ON,OFF)
	cmake --build build/engine --parallel $(JOBS)
	ctest --preset engine

test-sanitize: setup
	cmake --preset sanitize -DSPHEROSEG_WERROR=ON
	cmake --build build/sanitize --parallel $(JOBS)
	ctest --preset sanitize

# Archer tells the thread sanitizer what OpenMP synchronises; it comes with clang's OpenMP library.
test-race: setup
	cmake --preset thread
	cmake --build build/thread --parallel $(JOBS) --target race_tests
	SPHEROSEG_ARCHER=$$(ls $$(clang++ -print-resource-dir)/../../libarcher.so) ctest --preset thread

# libFuzzer with what is in tests/fuzz/corpus.txt; FUZZ_SECONDS, FUZZ_ARGUMENTS (docs/reliability.md).
FUZZ_SECONDS ?= 600
fuzz: setup
	cmake --preset fuzz
	cmake --build build/fuzz --parallel $(JOBS) --target segment_fuzzer
	$(VENV_PYTHON) tests/fuzz/corpus.py unpack tests/fuzz/corpus.txt out/fuzz/corpus
	OMP_WAIT_POLICY=passive LSAN_OPTIONS=suppressions=tests/engine/lsan.supp \
		build/fuzz/tests/fuzz/segment_fuzzer out/fuzz/corpus -artifact_prefix=out/fuzz/ \
		-max_len=200 -timeout=120 -max_total_time=$(FUZZ_SECONDS) $(FUZZ_ARGUMENTS)

test-plugin: setup
	cmake --preset plugin -DSPHEROSEG_WERROR=ON -DSPHEROSEG_BUILD_ADAPTER_TESTS=ON
	cmake --build build/plugin --parallel $(JOBS)
	ctest --preset plugin

# Most of these tests wait for processes: with pytest-xdist one module runs while another waits.
test-python: test-plugin
	$(VENV_PYTHON) -m pytest -n $(JOBS) --dist loadscope

# They wait for windows half of the time: three tests at once for every two cores.
test-gui: gui-root plugin-gui plugin
	SPHEROSEG_GUI_ROOT="$(GUI_ROOT)" $(VENV_PYTHON) -m pytest -n $$((($(JOBS) * 3 + 1) / 2)) tests/gui

# The screenshots of docs/meshlab.md; their originals stay in out/gui/docs.
docs-pictures: gui-root plugin-gui plugin
	SPHEROSEG_GUI_ROOT="$(GUI_ROOT)" $(VENV_PYTHON) tests/gui/docs_pictures.py

# Not part of `make test`: the same sources in the PyMeshLab releases before this one.
test-hosts: setup
	scripts/test_hosts.sh
