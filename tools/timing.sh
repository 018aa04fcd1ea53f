#!/bin/sh
# timing.sh BUILD: runs the tests of time limits and of heap memory, which depend on the machine. The machine should be otherwise idle.
set -eu
build=$1
export AJAR_BUILD="$PWD/$build" AJAR_TIMING=1
MALLOC_ARENA_MAX=1 "$build/tests/timing/ajar_timing" --gtest_brief=1
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider tests/blender/test_timing.py
if ls out/ajar-*-linux-x64.zip > /dev/null 2>&1; then
  AJAR_ZIPS="$PWD/out" PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider tests/compatibility/test_wheels.py -k time_limit
else
  echo "The time limit of a denoised render is not tested: there is no zip in out/ (make extension)."
fi
