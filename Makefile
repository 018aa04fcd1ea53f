# The README's two commands, each doing all its own set-up on a fresh Debian 12:
#   make render [SCENE=file.blend] [OUT=image.png|.exr] [ARGS="--ajar-samples 256"]
#   make test
# A private Blender profile inside the build tree is used; a user's own is never touched.

BLENDER ?= blender
SCENE   ?= test_scenes/room.blend
OUT     ?= out/$(basename $(notdir $(SCENE))).png
ARGS    ?=
PRESET  ?= release
BUILD   := build/$(PRESET)
PROFILE := $(abspath $(BUILD))/blender_profile

export BLENDER PRESET

.PHONY: all render test bench bench-full setup build install clean
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
	@tools/build.sh ci
	@tools/install_addon.sh build/ci $(abspath build/ci)/blender_profile
	@tools/test.sh build/ci

bench: install
	@/usr/bin/python3 benchmarks/bench.py --profile $(PROFILE) --build $(BUILD)

bench-full: install
	@/usr/bin/python3 benchmarks/bench.py --full --profile $(PROFILE) --build $(BUILD)

clean:
	rm -rf build out
