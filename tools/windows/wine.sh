#!/bin/sh
# wine.sh PROGRAM.exe [ARGUMENTS]: runs a program that was built for Windows under Wine, with a profile of its own in build/windows.
root=$(cd "$(dirname "$0")/../.." && pwd)
export WINEPREFIX="$root/build/windows/wine" WINEDEBUG="${WINEDEBUG:--all}" WINEDLLOVERRIDES="mscoree=;mshtml="
export WINEPATH="Z:$root/build/windows/prefix/bin;Z:$root/build/windows/prefix/oidn"
exec /usr/lib/wine/wine64 "$@"
