#!/bin/sh
# all.sh BUILD: lists and probes nodes and settings in Debian's Blender and in every bpy wheel that `make compat` has installed. Writes
# docs/coverage.md and tests/blender/panels/inventory.tsv. Takes about ten minutes for each Blender.
set -eu
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
here=$root/tools/coverage
work=$root/build/coverage
rm -rf "$work" && mkdir -p "$work/ajar" "$work/profile"
(cd "$work/ajar" && unzip -q "$root"/out/ajar-*[0-9]-linux-x64.zip)
export PYTHONDONTWRITEBYTECODE=1 BLENDER_USER_CONFIG="$work/profile" BLENDER_USER_SCRIPTS="$work/profile" BLENDER_USER_EXTENSIONS="$work/profile"

# run NAME: runs each script in one Blender. After a failure, the end of the log is printed.
run() {
  name=$1
  for script in "$root/tests/blender/panels/things.py" "$here/probe.py" "$here/settings_probe.py"; do
    out=$work/$(basename "$script" .py)_$name.json
    log=${out%.json}.log
    if [ "$name" = debian ]; then set -- "${BLENDER:-blender}" -b --factory-startup --python "$script" -- "$out"; else set -- "$python" "$script" "$out"; fi
    "$@" >"$log" 2>&1 || { tail -20 "$log"; echo "$name: $(basename "$script") failed; all of it is in $log" >&2; exit 1; }
    echo "$name: $(basename "$script" .py) done"
  done
}
export PYTHONPATH="$root/$build/python"
run debian
export PYTHONPATH="$work/ajar"
for python in $(ls -d "$root"/build/compat/bpy-*/bin/python | sort -V); do
  run "$(basename "${python%/bin/python}")"
done
/usr/bin/python3 "$here/write.py" $(ls "$work"/probe_*.json "$work"/settings_probe_*.json) >"$root/docs/coverage.md"
/usr/bin/python3 "$here/write_inventory.py" "$work"/*.json >"$root/tests/blender/panels/inventory.tsv"
/usr/bin/python3 "$here/judge.py" "$work"/*probe_*.json
