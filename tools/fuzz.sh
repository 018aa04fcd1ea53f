#!/usr/bin/env bash
# Builds the fuzzers with Clang and runs each for $1 seconds, starting from valid scenes. Ends with an error if a fuzzer finds a fault.
set -euo pipefail
cd "$(dirname "$0")/.."
build=build/fuzz
mkdir -p build
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DCMAKE_CXX_COMPILER=clang++-16 -DAJAR_PYTHON=OFF -DAJAR_TESTS=OFF -DAJAR_FUZZERS=ON \
      -DAJAR_SANITIZERS=address,undefined,float-cast-overflow,fuzzer-no-link > "$build.log"
cmake --build "$build" --target fuzz_scene fuzz_graph fuzz_checkpoint fuzz_ies fuzz_image make_corpus
mkdir -p "$build/scenes" "$build/graphs" "$build/checkpoints" "$build/ies" "$build/images"
cp tests/core/ies/*.ies "$build/ies"
"$build/tests/fuzz/make_corpus" "$build/scenes" "$build/images"
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
"$build/tests/fuzz/fuzz_graph" -max_total_time="$1" -max_len=2048 -artifact_prefix="$build/" -print_final_stats=1 "$build/graphs"
"$build/tests/fuzz/fuzz_checkpoint" -max_total_time="$1" -rss_limit_mb=2048 -max_len=65536 -artifact_prefix="$build/" -print_final_stats=1 "$build/checkpoints"
"$build/tests/fuzz/fuzz_ies" -max_total_time="$1" -max_len=8192 -artifact_prefix="$build/" -print_final_stats=1 "$build/ies"
# OpenImageIO leaks a message of 31 bytes for each PNG file that libpng refuses, and OpenEXR allocates the size of a text before it reads it (up to 2 GB).
ASAN_OPTIONS=quarantine_size_mb=64:detect_leaks=0 "$build/tests/fuzz/fuzz_image" -max_total_time="$1" -rss_limit_mb=4096 -max_len=65536 -artifact_prefix="$build/" -print_final_stats=1 "$build/images" 2>&1 | grep -v "^libpng"
# A valid description can need much memory or time, which is not a fault, so that both are limited here.
"$build/tests/fuzz/fuzz_scene" -max_total_time="$1" -rss_limit_mb=4096 -timeout=60 -artifact_prefix="$build/" -print_final_stats=1 "$build/scenes"
