#!/bin/sh
# timing.sh BUILD: runs the tests of time limits and of heap memory, which depend on the machine. The machine should be otherwise idle.
set -eu
build=$1
export AJAR_BUILD="$PWD/$build" AJAR_TIMING=1
MALLOC_ARENA_MAX=1 "$build/tests/timing/ajar_timing" --gtest_brief=1
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider tests/blender/test_timing.py
