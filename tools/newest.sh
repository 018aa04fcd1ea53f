#!/bin/sh
# newest.sh [ROOT]: runs the tests that need a window, and those of the manual and the German translation, in the newest Blender of Debian sid (5.2
# LTS at the time of writing), with the core built with the libraries of sid. Requires root rights and debootstrap. The first run needs 6 GB and about
# a quarter of an hour. An existing ROOT (default /var/tmp/ajar_sid) is used again.
set -eu
root=${1:-/var/tmp/ajar_sid}
here=$(cd "$(dirname "$0")/.." && pwd)
[ -x "$root/usr/bin/apt-get" ] || debootstrap --variant=minbase sid "$root" http://deb.debian.org/debian >/dev/null
cp /etc/resolv.conf "$root/etc/"
for folder in proc dev; do
  mountpoint -q "$root/$folder" || mount --bind "/$folder" "$root/$folder"
done
trap 'umount "$root/proc" "$root/dev"' EXIT
# A mirror that is not updated has a release file that has expired.
chroot "$root" apt-get -o Acquire::Check-Valid-Until=false update -qq
# The last line has the modules that Blender's add-ons import (cattrs is not packaged), a program for screenshots, and the packages for the manual.
DEBIAN_FRONTEND=noninteractive chroot "$root" apt-get install -y -qq --no-install-recommends make git g++ cmake ninja-build libembree-dev libosd-dev libopenimageio-dev libopenexr-dev libglm-dev \
  libtbb-dev pybind11-dev python3-dev python3-numpy nlohmann-json3-dev libcli11-dev blender xvfb libgl1-mesa-dri python3-pytest \
  python3-requests python3-attr python3-typing-extensions python3-pip python3-pil python3-markdown >/dev/null
chroot "$root" python3 -c 'import cattrs' 2>/dev/null || chroot "$root" python3 -m pip install -q --break-system-packages --no-deps cattrs
rm -rf "$root/ajar/source" && mkdir -p "$root/ajar"
git clone -q "$here" "$root/ajar/source"
exec_in() { chroot "$root" sh -c "cd /ajar/source && HOME=/root $1"; }
mkdir -p "$root/ajar/build" && ln -s ../build "$root/ajar/source/build"
exec_in 'tools/build.sh release'
# The library that stands for the denoiser in the tests of the window.
exec_in 'mkdir -p build/release/tests/core && g++ -std=c++20 -O2 -shared -fPIC tests/core/denoise/stand_in_library.cpp -o build/release/tests/core/ajar_stand_in_denoiser.so'
exec_in 'AJAR_BUILD=/ajar/build/release python3 -m pytest -q -p no:cacheprovider tests/blender/test_window.py tests/blender/test_editors.py tests/blender/test_panels.py tests/blender/test_inventory.py'
exec_in 'AJAR_BUILD=/ajar/build/release python3 -m pytest -q -p no:cacheprovider tests/blender/test_inside.py -k "manual or translations"'
