#!/bin/sh
# test.sh BUILD: runs all tests that every change must pass, with progress, and prints their counts at the end.
#
# The tests of the core run in two processes beside the Python tests, because most tests use one thread: both cores stay busy until the end. The tests
# of the core have a lower priority, so that the windows of the Python tests still answer at once. Their output follows that of the Python tests.
set -u
build=$1
export AJAR_BUILD="$PWD/$build"
results=$AJAR_BUILD/test_results
mkdir -p "$results"
rm -f "$results"/*.xml
core=
trap 'kill $core 2> /dev/null' EXIT
trap 'exit 130' INT TERM
for shard in 0 1; do
  GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX=$shard nice -n 5 "$build/tests/core/ajar_tests" --gtest_brief=1 --gtest_output="xml:$results/core_$shard.xml" \
    > "$results/core_$shard.log" 2>&1 &
  core="$core $!"
done
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider -o console_output_style=times --junitxml="$results/python.xml" tests
shard=0
for process in $core; do
  tail -n +1 -f --pid="$process" "$results/core_$shard.log"
  shard=$((shard + 1))
done
/usr/bin/python3 tools/test_summary.py "$results"/core_0.xml "$results"/core_1.xml "$results/python.xml"
