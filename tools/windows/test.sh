#!/usr/bin/env bash
# test.sh [GTEST_FILTER]: builds Ajar for Windows, runs the tests of the core under Wine, and compares a picture of ajar-render.exe with that of Linux,
# if there is a build for Linux. The first run downloads and builds the libraries (tools/windows/libraries.py).
set -euo pipefail
cd "$(dirname "$0")/../.."
tree=build/windows/ajar
# What Wine cannot do, with reasons in docs/developer/platforms.md.
skipped=''

python3 tools/windows/libraries.py
mkdir -p "$tree"
[ -f "$tree/build.ninja" ] || cmake -S . -B "$tree" -G Ninja -DCMAKE_TOOLCHAIN_FILE=cmake/mingw.cmake -DAJAR_WINDOWS="$PWD/build/windows/prefix" -DAJAR_PYTHON=OFF \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST > "$tree/configure.log" 2>&1 || { cat "$tree/configure.log" >&2; exit 1; }
nice -n 5 ninja -C "$tree" -j"${AJAR_JOBS:-$(nproc)}" ajar_tests ajar_cli
tools/windows/wine.sh "$tree/tests/core/ajar_tests.exe" --gtest_brief=1 --gtest_filter="${1:-*}${skipped:+-$skipped}" | tee "$tree/tests.log"
# The exit code of Wine is 0 after a crash too.
grep -q '^core: [0-9]* passed, 0 failed' "$tree/tests.log" || { echo "the tests did not reach their end" >&2; exit 1; }

if [ -x build/release/ajar-render ]; then
  /usr/bin/python3 tools/windows/compare.py build/release
else
  echo "no build for Linux in build/release: no picture was compared"
fi
