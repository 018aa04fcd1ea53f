#!/bin/sh
# render.sh PROFILE SCENE OUT [--ajar-...]: renders one frame with the engine AJAR in the private profile.
set -eu
profile=$1
scene=$2
out=$3
shift 3
[ -f "$scene" ] || { echo "There is no scene file '$scene'." >&2; exit 2; }
case "$out" in
  *.png|*.PNG|*.exr|*.EXR) ;;
  *) echo "OUT must end in .png or .exr, not '$out'." >&2; exit 2 ;;
esac
mkdir -p "$(dirname "$out")"
root=$(cd "$(dirname "$0")/.." && pwd)
BLENDER_USER_CONFIG="$profile/config" BLENDER_USER_SCRIPTS="$profile/scripts" \
  "${BLENDER:-blender}" -b --factory-startup --addons ajar_render "$scene" -E AJAR \
  --python-exit-code 1 --python "$root/tools/render_to_file.py" -- --output "$(realpath -m "$out")" "$@"
