# The README's two commands, each doing all its own set-up on a fresh Debian 12:
#   make render [SCENE=file.blend] [OUT=image.png|.exr] [ARGS="--ajar-samples 256"]
#   make test
# A private Blender profile inside the build tree is used; a user's own is never touched.

BLENDER ?= blender
SCENE   ?= test_scenes/room.blend
OUT     ?= out/$(basename $(notdir $(SCENE))).png
# The first picture is done within a minute, with as many samples as that takes.
ARGS    ?= $(if $(filter test_scenes/room.blend,$(SCENE)),--ajar-time 50 --ajar-samples 1000000)
PRESET  ?= release
BUILD   := build/$(PRESET)
# A Python with a newer official Blender, once `make compat` has one: Cycles of it becomes a column of the benchmarks.
WHEEL   ?= $(lastword $(sort $(wildcard $(CURDIR)/build/compat/bpy-*/bin/python)))
PROFILE := $(abspath $(BUILD))/blender_profile

export BLENDER PRESET

.PHONY: all test-all windows-test windows-extension release farm-test extension compat coverage manual pictures newest profile render lint test fuzz sanitize bench-check agreement bench bench-full clean-picture bench_program timing setup build install clean
all: build

setup:
	@tools/setup.sh

build: setup
	@tools/build.sh $(PRESET)

install: build
	@tools/install_addon.sh $(BUILD) $(PROFILE)

render: install
	@tools/render.sh $(PROFILE) "$(SCENE)" "$(OUT)" $(ARGS)

test:
	@tools/setup.sh test
	@tools/build.sh $(PRESET) tests
	@tools/install_addon.sh $(BUILD) $(PROFILE)
	@tools/test.sh $(BUILD)

# Also the pairs of scenes and techniques, the settings, and the Blenders that the gate has no time for.
test-all: export AJAR_ALL_TESTS = 1
test-all: export AJAR_AGREEMENT = 1
test-all: test

# All Python, and the C++ files that differ from main.
lint:
	@tools/setup.sh lint
	@tools/lint.sh all $(BUILD)

extension:
	@tools/setup.sh extension
	@/usr/bin/python3 tools/extension/build.py

# The core for Windows, and its tests under Wine. The first run builds the libraries, for about half an hour.
windows-test:
	@tools/setup.sh windows
	@tools/windows/test.sh

# out/ajar-*-windows-x64-untested.zip, of what windows-test has built, and tests of its module in official Python under Wine. Nobody has run it in Blender yet.
windows-extension: windows-test
	@/usr/bin/python3 tools/windows/extension.py
	@/usr/bin/python3 tools/windows/module_test.py

# out/release: a folder for any web server, from which Blender installs and updates the extension. It is written only if the zips work in all Blenders at hand.
release: extension install
	@AJAR_ZIPS=$(CURDIR)/out AJAR_BUILD=$(CURDIR)/$(BUILD) PYTHONPATH=$(CURDIR)/$(BUILD)/python /usr/bin/python3 -m pytest -q -p no:cacheprovider tests/compatibility
	@/usr/bin/python3 tests/compatibility/compatibility.py
	@/usr/bin/python3 tools/extension/release.py

compat: extension install
	@/usr/bin/python3 tests/compatibility/compatibility.py

# docs/manual/settings.md from the add-on's descriptions; and the pictures of the manual.
manual: install
	@BLENDER_USER_CONFIG=$(PROFILE)/config BLENDER_USER_SCRIPTS=$(PROFILE)/scripts \
	  $(BLENDER) -b --factory-startup --addons ajar_render --python-exit-code 1 --python tools/manual/settings.py -- docs/manual/settings.md

pictures: install
	@tools/setup.sh pictures
	@/usr/bin/python3 tools/manual/pictures.py --build $(BUILD)

# What becomes of each shader node and setting, beside Cycles, in Debian's Blender and each wheel that `make compat` has brought: docs/coverage.md and
# tests/blender/panels/inventory.tsv. About ten minutes for each Blender.
coverage: extension install
	@tools/coverage/all.sh $(BUILD)

# The tests with a window in the newest Blender of Debian, in a folder of its own. Needs root.
newest:
	@tools/newest.sh

# The farm on a Slurm cluster of one node, which is started for it and stopped again. Needs root.
farm-test: install
	@tools/farm/test.sh $(BUILD)

agreement: install
	@tools/setup.sh test
	@AJAR_AGREEMENT=1 AJAR_BUILD=$(abspath $(BUILD)) PYTHONPATH=$(abspath $(BUILD))/python \
	  /usr/bin/python3 -m pytest -q -p no:cacheprovider tests/render/test_agreement_with_cycles.py tests/render/test_features.py \
	  tests/compatibility/test_wheel_features.py tests/compatibility/test_wheel_images.py

bench_program: install
	@tools/setup.sh bench
	@cmake -DAJAR_BENCHMARKS=ON $(BUILD) > $(BUILD)/configure.log && cmake --build $(BUILD) --target bare_embree ajar_timing

# What must happen within a time or a size that depends on the machine.
timing: bench_program
	@tools/timing.sh $(BUILD)

# About a quarter of an hour together, by reckoning (bench.py takes nine minutes); either program alone, with its own defaults, knows more.
bench: bench_program timing
	@/usr/bin/python3 benchmarks/bench.py --seconds 1 --build $(BUILD) $(WHEEL:%=--wheel %)
	@/usr/bin/python3 benchmarks/techniques.py --seconds 2 --repeats 1 --reference-seconds 30 --build $(BUILD) $(WHEEL:%=--wheel %)

bench-full: bench_program
	@/usr/bin/python3 benchmarks/bench.py --full --build $(BUILD) $(WHEEL:%=--wheel %)
	@/usr/bin/python3 benchmarks/techniques.py --seconds 30 --reference-seconds 1800 --build $(BUILD) $(WHEEL:%=--wheel %)
	@/usr/bin/python3 benchmarks/thesis.py --build $(BUILD)
	@$(MAKE) clean-picture

# How long an artist waits for a clean picture, beside Cycles of the newest wheel: docs/benchmarks/clean_picture.md. About an hour for each file.
clean-picture: extension
	@tools/setup.sh bench
	@/usr/bin/python3 benchmarks/clean_picture.py

# Scene files and shader graphs made to break things, for so many seconds each. What breaks is left in build/fuzz.
FUZZ_SECONDS ?= 60
fuzz:
	@tools/setup.sh fuzz
	@tools/fuzz.sh $(FUZZ_SECONDS)

# The core's tests with the sanitizers of addresses and undefined behaviour, then those in which threads meet with that of threads.
sanitize:
	@tools/setup.sh sanitize
	@tools/sanitize.sh

# Where the time of path tracing goes, by phase: docs/benchmarks/profile.md.
profile: install
	@tools/setup.sh bench
	@/usr/bin/python3 benchmarks/profile.py --build $(BUILD)

bench-check: install
	@tools/setup.sh bench
	@/usr/bin/python3 benchmarks/check.py --build $(BUILD)

clean:
	rm -rf build out
