#!/bin/sh
# build.sh PRESET: configure and build for the Python inside Blender, which decides the module's ABI.
set -eu
preset=$1
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
if [ ! -f "$build/build.ninja" ] || [ "$asked" -nt "$build/build.ninja" ]; then
  cmake --preset "$preset" -DAJAR_PYTHON_INCLUDE="$include" -DAJAR_PYTHON_SUFFIX="$suffix" > "$build/configure.log" 2>&1 ||
    { cat "$build/configure.log" >&2; exit 1; }
fi
target=""
[ "$preset" = release ] && target="--target ajar_runtime"
# shellcheck disable=SC2086
cmake --build "$build" $target
