#!/bin/sh
# Installs missing Debian packages. Requires root rights only if packages are missing. `setup.sh test` adds the packages for tests, `bench` for
# benchmarks, `lint` for the checks of the sources, `fuzz` Clang, `pictures` for screenshots of the manual, `sanitize` for building TBB, `extension`
# for packing and testing the extension, `windows` the compiler for Windows and Wine.
set -eu
packages="g++ cmake ninja-build libembree-dev libosd-dev libopenimageio-dev libopenexr-dev libglm-dev libtbb-dev
 pybind11-dev python3-dev python3-numpy python3-openvdb python3-markdown nlohmann-json3-dev libcli11-dev"
[ "${BLENDER:-blender}" = blender ] && packages="$packages blender"
# The second line has libraries of the system that official Blender uses.
extension="python3-venv ca-certificates curl binutils
 libgl1 libice6 libsm6 libx11-6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxxf86vm1"
case "${1:-}" in
  test) packages="$packages libgtest-dev libboost-dev python3-pytest python3-pil xvfb strace $extension" ;;
  extension) packages="$packages $extension" ;;
  bench) packages="$packages python3-matplotlib valgrind libgtest-dev libboost-dev python3-pytest" ;;
  sanitize) packages="$packages libgtest-dev libboost-dev curl ca-certificates xz-utils" ;;
  pictures) packages="$packages xvfb python3-pil" ;;
  lint) packages="$packages python3-venv ca-certificates clang-format clang-tidy" ;;
  windows) packages="$packages libboost-dev g++-mingw-w64-x86-64-posix wine64 nasm bzip2 xz-utils $extension" ;;
  fuzz) packages="$packages clang-16 libclang-rt-16-dev libgtest-dev libboost-dev" ;;
esac
missing=""
for package in $packages; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
[ -z "$missing" ] && exit 0
as_root=""
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "Please install as root:$missing" >&2; exit 1; }
  as_root=sudo
fi
echo "Installing:$missing"
$as_root apt-get update -qq
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
