#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ranks.sh FOLDER GXYDATA GXYRENDER MPIEXEC...: pictures and depths of the states in states/ are the same bytes on 1, 2,
# 3, 4 and 8 ranks, with other packets and partitions too.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1 gxydata=$2 gxyrender=$3
shift 3
rm -rf "$out"
mkdir -p "$out"
cd "$out"
"$gxydata" turbulence -r 34,29,31 --seed 7 noise.vol
"$gxydata" radial -r 27 balls.vti
"$gxydata" particles -r 400 halos.vtp
"$gxydata" sphere-mesh ball.vtp
cp "$here"/states/*.json .

render() {  # NAME RANKS OPTIONS...
  local name=$1 ranks=$2
  shift 2
  for state in volume geometry; do
    "${mpiexec[@]}" -n "$ranks" "$gxyrender" "$state.json" -o "$state-$name" --format raw --depth "$@"
  done
}
mpiexec=("$@")
render reference 1 --partitions 1
for ranks in 2 3 4 8; do render "on$ranks" "$ranks"; done
render packets 3 --partitions 3,2,3 --packet 16

compared=0
for expected in *-reference_*; do
  for name in on2 on3 on4 on8 packets; do
    cmp "$expected" "${expected/reference/$name}"
    compared=$((compared + 1))
  done
done
((compared == 30)) || { echo "compared $compared pairs of files, expected 30" >&2; exit 1; }
