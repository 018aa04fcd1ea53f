#!/usr/bin/env bash
# sanitize.sh [address|thread] [GTEST_FILTER]: runs the tests of the core with one sanitizer, or with both if none is named. The thread sanitizer must
# instrument TBB, otherwise it reports a race at each transfer of work between threads. TBB is therefore built with the sanitizer, in the version of
# the headers, and replaces the TBB of the system in the tests, also for Embree and OpenImageIO. tools/thread_sanitizer.supp lists the remaining
# reports with their reasons.
set -euo pipefail
cd "$(dirname "$0")/.."
kind=${1:-both}
# Tests in which threads interact: sessions and their owners, tiles, chains, populations, guides, maps, caches, and tests of independence of the
# number of threads.
threads='*Session*:*hread*:Drift.*:GuidedPaths.*:RenderPlan.*:MergingWith.*:PhotonMapping.*:Photons.*:ImageSampling.*:TechniqueChoice.*'
threads+=':Scene.*:Texture.*:AlbedoTable.*:Checkpoint.*:DirectMethods*:*StressTest*far_from*:*StressTest*every_volume:*StressTest*ten_thousand*'

address() {
  cmake --preset sanitizers > build/sanitizers.log
  cmake --build build/sanitizers --target ajar_tests
  # Embree keeps its memory until the process ends.
  ASAN_OPTIONS=detect_leaks=1 LSAN_OPTIONS=suppressions=$PWD/tools/leak_sanitizer.supp UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
    build/sanitizers/tests/core/ajar_tests --gtest_brief=1 --gtest_filter="${1:-*}"
}

instrumented_tbb() {
  local version=2021.8.0 sum=7e9111b8bb59c8800bf6d0b06afe7b0891937443d2dae1ee1101c8e2ede6a7ef to=$1
  [ -e "$to/libtbb.so.12" ] && return
  mkdir -p "$to"
  curl -fsSL -o "$to/source.tar.xz" "https://deb.debian.org/debian/pool/main/o/onetbb/onetbb_$version.orig.tar.xz"
  echo "$sum  $to/source.tar.xz" | sha256sum -c --quiet
  tar -C "$to" -xf "$to/source.tar.xz"
  cmake -S "$to/oneTBB-$version" -B "$to/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF -DTBB_STRICT=OFF > "$to/configure.log"
  cmake --build "$to/build" --target tbb
  cp -P "$to"/build/*_relwithdebinfo/libtbb.so.12* "$to"
}

thread() {
  cmake --preset thread_sanitizer > build/thread_sanitizer.log
  instrumented_tbb "$PWD/build/thread_sanitizer/tbb"
  cmake --build build/thread_sanitizer --target ajar_tests
  LD_LIBRARY_PATH=$PWD/build/thread_sanitizer/tbb TSAN_OPTIONS=suppressions=$PWD/tools/thread_sanitizer.supp:halt_on_error=0:exitcode=66 \
    build/thread_sanitizer/tests/core/ajar_tests --gtest_brief=1 --gtest_filter="${1:-$threads}"
}

mkdir -p build
case "$kind" in
  address) address "${2:-}" ;;
  thread) thread "${2:-}" ;;
  both) address && thread ;;
  *) echo "usage: sanitize.sh [address|thread] [GTEST_FILTER]" >&2; exit 2 ;;
esac
