#!/bin/sh
# build.sh PRESET [tests]: configures and builds for the Python of Blender, which defines the ABI of the module. Without `tests`, builds only the
# renderer. Both use the same build tree, so that the core is compiled once.
set -eu
preset=$1
what=${2:-runtime}
blender=${BLENDER:-blender}
build=build/$preset
asked=$build/blender_python
mkdir -p "$build"
if [ ! -s "$asked" ] || [ "$(head -n 1 "$asked")" != "$(command -v "$blender")" ]; then
  command -v "$blender" > "$asked.new" || { echo "Blender '$blender' was not found; set BLENDER=." >&2; exit 1; }
  "$blender" -b --factory-startup --python-expr \
    "import sysconfig; print('ajar-python', '%s' % sysconfig.get_paths()['include'], sysconfig.get_config_var('EXT_SUFFIX'))" \
    2>/dev/null | grep '^ajar-python' >> "$asked.new"
  mv "$asked.new" "$asked"
fi
include=$(sed -n 's/^ajar-python \([^ ]*\) .*/\1/p' "$asked")
suffix=$(sed -n 's/^ajar-python [^ ]* //p' "$asked")
configure() {
  cmake --preset "$preset" -DAJAR_PYTHON_INCLUDE="$include" -DAJAR_PYTHON_SUFFIX="$suffix" "$@" > "$build/configure.log" 2>&1 ||
    { cat "$build/configure.log" >&2; exit 1; }
}
# Only the tests need GoogleTest.
if [ "$what" = tests ]; then
  grep -q '^AJAR_TESTS:BOOL=ON' "$build/CMakeCache.txt" 2>/dev/null && [ "$asked" -ot "$build/build.ninja" ] || configure -DAJAR_TESTS=ON
  exec cmake --build "$build"
fi
if [ ! -f "$build/build.ninja" ]; then configure -DAJAR_TESTS=OFF
elif [ "$asked" -nt "$build/build.ninja" ]; then configure
fi
exec cmake --build "$build" --target ajar_runtime
