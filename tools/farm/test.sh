#!/usr/bin/env bash
# test.sh BUILD: starts a Slurm cluster of one node, runs the tests of the farm on it, and stops it again.
set -euo pipefail
build=$1
missing=""
for package in slurm-wlm munge; do
  dpkg-query -W -f='${Status}' "$package" 2> /dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
if [ -n "$missing" ]; then
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing > /dev/null
fi
folder=$(mktemp -d /tmp/ajar-cluster-XXXXXX)
trap 'tools/farm/cluster.sh stop "$folder"; rm -rf "$folder"' EXIT
tools/farm/cluster.sh start "$folder"
SLURM_CONF=$folder/slurm.conf AJAR_BUILD=$PWD/$build PYTHONPATH=$PWD/$build/python /usr/bin/python3 -m pytest -q -p no:cacheprovider --durations=0 tests/farm/real_slurm.py ${2:+-k "$2"}
