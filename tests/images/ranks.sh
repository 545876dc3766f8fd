#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ranks.sh BACKEND DEVICE FOLDER GXYDATA GXYRENDER SAME_PICTURES MPIEXEC...: pictures and depths of states/kinds.json, whose
# data come from files of several formats, are the same as Embree's on one rank (bit for bit, but of a GPU: same_pictures.cpp), on
# 2, 3, 4 and 8 ranks (vulkan: 2, as each rank compiles all shaders), with other packets, partitions and threads; and on two ranks
# of which only one has the backend. All of them are left in FOLDER, with NAME_difference.png of those that are not the same.
set -euo pipefail

# Three path lines, with a value along each.
helices() {
  awk 'BEGIN {
    lines = 3; points = 25
    print "# vtk DataFile Version 3.0\nhelices\nASCII\nDATASET POLYDATA\nPOINTS " lines * points " float"
    for (l = 0; l < lines; l++)
      for (i = 0; i < points; i++) {
        a = 0.4 * i + 2.1 * l
        printf "%.4f %.4f %.4f\n", 0.8 * cos(a), i / 12 - 1, 0.8 * sin(a)
      }
    print "LINES " lines " " lines * (points + 1)
    for (l = 0; l < lines; l++) {
      printf "%d", points
      for (i = 0; i < points; i++) printf " %d", l * points + i
      print ""
    }
    print "POINT_DATA " lines * points "\nSCALARS along float 1\nLOOKUP_TABLE default"
    for (i = 0; i < lines * points; i++) print (i % points) / points
  }'
}
here=$(cd "$(dirname "$0")" && pwd)
backend=$1 device=$2 out=$3 gxydata=$4 gxyrender=$5 same_pictures=$6  # DEVICE: empty where the backend has none to choose from
shift 6
options=(--backend "$backend" ${device:+--device "$device"})
rm -rf "$out"
mkdir -p "$out"
cd "$out"
"$gxydata" turbulence -r 34,29,31 --seed 7 noise.vol
"$gxydata" radial -r 27 balls.vti
"$gxydata" particles -r 400 halos.vtp
"$gxydata" sphere-mesh ball.vtp
helices > helices.vtk
cp "$here"/states/kinds.json .

render() {  # NAME RANKS OPTIONS...
  local name=$1 ranks=$2
  shift 2
  "${mpiexec[@]}" -n "$ranks" "$gxyrender" kinds.json -o "$name" --format raw --depth "$@"
}
mpiexec=("$@")
render reference 1 --partitions 1 --backend embree
case $backend in vulkan) counts=(2) ;; *) counts=(2 3 4 8) ;; esac
for ranks in "${counts[@]}"; do render "on$ranks" "$ranks" "${options[@]}"; done
all=(kinds.json -o mixed --format raw --depth)
"${mpiexec[@]}" -n 1 "$gxyrender" "${all[@]}" --backend embree : -n 1 "$gxyrender" "${all[@]}" "${options[@]}"
render packets 3 --partitions 3,2,3 --packet 16 --threads 2 "${options[@]}"

gxydiff=$(dirname "$gxyrender")/gxydiff
differ() {  # EXPECTED FOUND SIZE: where they are, and in how much they differ
  local found=$PWD/$2 difference=$PWD/${2%.*}_difference.png
  echo "FAILED: $found is not $PWD/$1" >&2
  "$gxydiff" "$1" "$2" --alpha --size "$3" --output "$difference" >&2 || echo "see $difference" >&2
}
compared=0 different=0
export TEST_TMPDIR=$PWD/
for expected in reference_*.raw; do
  case $(stat -c %s "$expected") in 122880) size=96x80 ;; *) size=64x64 ;; esac  # of kinds.json
  for name in "${counts[@]/#/on}" mixed packets; do
    found=${expected/reference/$name}
    [[ -e ${expected%.raw}.depth && -e ${found%.raw}.depth ]] || { echo "no depths of $found" >&2; exit 1; }
    "$same_pictures" --backend="$backend" --size="$size" "$expected" "$found" || {
      differ "$expected" "$found" "$size"
      different=$((different + 1))
    }
    compared=$((compared + 1))
  done
done
pictures=$((4 * (${#counts[@]} + 2)))
((compared == pictures)) || { echo "compared $compared pairs of pictures, expected $pictures" >&2; exit 1; }
((different == 0))
