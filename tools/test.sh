#!/bin/sh
# test.sh BUILD: runs all tests that every change must pass, with progress, and prints their counts at the end.
#
# The tests of the core run beside the Python tests, because most of both use one thread. The tests of the core have a lower priority, so that the
# windows of the Python tests still answer at once. Their output follows that of the Python tests.
set -u
build=$1
export AJAR_BUILD="$PWD/$build"
results=$AJAR_BUILD/test_results
mkdir -p "$results"
rm -f "$results"/*.xml
nice -n 5 "$build/tests/core/ajar_tests" --gtest_brief=1 --gtest_output="xml:$results/core.xml" > "$results/core.log" 2>&1 &
core=$!
trap 'kill $core 2> /dev/null' EXIT
trap 'exit 130' INT TERM
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider -o console_output_style=times --junitxml="$results/python.xml" tests
tail -n +1 -f --pid="$core" "$results/core.log"
/usr/bin/python3 tools/test_summary.py "$results/core.xml" "$results/python.xml"
