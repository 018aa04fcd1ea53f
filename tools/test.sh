#!/bin/sh
# test.sh BUILD: every test of the gate.
set -eu
build=$1
export AJAR_BUILD="$PWD/$build"
"$build/tests/core/ajar_tests" --gtest_brief=1
PYTHONPATH="$AJAR_BUILD/python" /usr/bin/python3 -m pytest -q -p no:cacheprovider tests
