#!/bin/sh
# install_addon.sh BUILD PROFILE: installs the add-on, its compiled module and the manual in a private Blender profile.
set -eu
build=$1
profile=$2
addon=$profile/scripts/addons/ajar_render
root=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$profile/config" "$profile/scripts/addons"
rm -rf "$addon"
cp -r "$root/python_addon" "$addon"
cp -r "$build/python/ajar" "$addon/ajar"
/usr/bin/python3 "$root/tools/manual/pages.py" "$addon/manual"
