#!/bin/sh
# test.sh BUILD: runs all tests that every change must pass, with progress, and prints their counts at the end.
set -u
build=$1
export AJAR_BUILD="$PWD/$build"
results=$AJAR_BUILD/test_results
mkdir -p "$results"
rm -f "$results"/*.xml
"$build/tests/core/ajar_tests" --gtest_brief=1 --gtest_output="xml:$results/core.xml"
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider -o console_output_style=times --junitxml="$results/python.xml" tests
exec /usr/bin/python3 tools/test_summary.py "$results/core.xml" "$results/python.xml"
