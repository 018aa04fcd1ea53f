#!/bin/sh
# all.sh BUILD: probes of nodes and settings in Debian's Blender and in the newest bpy wheel; writes docs/coverage.md. About ten minutes.
set -eu
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
here=$root/tools/coverage
work=$root/build/coverage
python=$(ls -d "$root"/build/compat/bpy-*/bin/python | sort -V | tail -1)
mkdir -p "$work"
rm -rf "$work/ajar" && (cd "$work" && unzip -q -o "$root"/out/ajar-*[0-9]-linux-x64.zip)
export PYTHONDONTWRITEBYTECODE=1
for probe in probe settings_probe; do
  PYTHONPATH=$root/$build/python "${BLENDER:-blender}" -b --factory-startup --python-exit-code 1 --python "$here/$probe.py" -- "$work/${probe}_debian.json" >"$work/log" 2>&1
  PYTHONPATH=$work "$python" "$here/$probe.py" "$work/${probe}_newest.json" >"$work/log" 2>&1
done
/usr/bin/python3 "$here/write.py" "$work/probe_debian.json" "$work/probe_newest.json" "$work/settings_probe_debian.json" "$work/settings_probe_newest.json" >"$root/docs/coverage.md"
/usr/bin/python3 "$here/judge.py" "$work"/*.json
