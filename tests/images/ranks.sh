#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ranks.sh BACKEND DEVICE FOLDER GXYDATA GXYRENDER MPIEXEC...: pictures and depths of the states in states/ are the same bytes as
# Embree's on one rank, on 2, 3, 4 and 8 ranks (vulkan: 2 and 4), with other packets and partitions too.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
backend=$1 device=$2 out=$3 gxydata=$4 gxyrender=$5  # DEVICE: empty where the backend has none to choose from
shift 5
options=(--backend "$backend" ${device:+--device "$device"})
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
render reference 1 --partitions 1 --backend embree
case $backend in vulkan) counts=(2 4) ;; *) counts=(2 3 4 8) ;; esac
for ranks in "${counts[@]}"; do render "on$ranks" "$ranks" "${options[@]}"; done
render packets 3 --partitions 3,2,3 --packet 16 "${options[@]}"

compared=0
for expected in *-reference_*; do
  for name in "${counts[@]/#/on}" packets; do
    cmp "$expected" "${expected/reference/$name}"
    compared=$((compared + 1))
  done
done
expected=$((6 * (${#counts[@]} + 1)))
((compared == expected)) || { echo "compared $compared pairs of files, expected $expected" >&2; exit 1; }
