#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# failures.sh BACKEND DEVICE FOLDER GXYDATA GXYRENDER MPIEXEC...: what gxyrender leaves behind when it cannot write, when a
# rank is killed, and when it is interrupted: an exit status that says so, one message, and no part of a picture under a
# picture's name.
set -uo pipefail
backend=$1 device=$2 out=$3 gxydata=$4 gxyrender=$5  # DEVICE: empty where the backend has none to choose from
shift 5
options=(--backend "$backend" ${device:+--device "$device"})
mpiexec=("$@")
rm -rf "$out"
mkdir -p "$out"
cd "$out" || exit 1
failures=0
failed() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

"$gxydata" turbulence -r 34,29,31 --seed 7 noise.vol || exit 1
state() {  # CAMERAS: a state file with so many, all the same
  local camera='{"viewpoint": [2.4, 1.7, 3.4], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "dimensions": [160, 120]}'
  printf '{"Datasets": {"name": "noise", "type": "Volume", "filename": "noise.vol"}, "Visualization": {"operators": ['
  printf '{"type": "Volume", "dataset": "noise", "colormap": "Viridis", "volume rendering": true}]}, "Cameras": ['
  for ((i = 1; i < $1; i++)); do printf '%s,\n' "$camera"; done
  printf '%s]}\n' "$camera"
}
state 1 >one.json
state 5000 >many.json

# Ends with status 1 and a single message that names the file, of which nothing is left.
cannot_write() {  # FILE OPTIONS...
  local file=$1 status said
  shift
  said=$(timeout 150 "${mpiexec[@]}" -n 2 "$gxyrender" one.json -q "${options[@]}" "$@" 2>&1)
  status=$?
  ((status == 1)) || failed "$file: status $status, expected 1"
  echo "$said"
  [[ $(grep -c 'gxyrender: error:' <<<"$said") == 1 && $said == *"error: "*"$file: "* ]] ||
    failed "$file: expected one error that names it, found: $said"
  [[ ! -e $file && ! -L $file.partial ]] || failed "$file: something is left behind"
}

for format in png exr raw; do
  cannot_write "missing/a_00000.$format" -o missing/a --format "$format"
  ln -s /dev/full "full_00000.$format.partial"  # where it is written first
  cannot_write "full_00000.$format" -o full --format "$format"
done
ln -s /dev/full deep_00000.depth.partial
cannot_write deep_00000.depth -o deep --format raw --depth
ln -s /dev/full stats.json.partial
cannot_write stats.json -o well --format raw --stats stats.json

runs() { grep -qs '^State:[[:space:]]*[^ZX[:space:]]' "/proc/$1/status"; }  # and is not merely unburied

# Stopped after its first pictures, it ends at once, with a status that is not 0; every picture there is is whole.
stopped_by() {  # NAME COMMAND: the command gets the process ids of mpiexec and of the ranks
  local name=$1 stop=$2 status pictures=0 ranks
  "${mpiexec[@]}" -n 3 "$gxyrender" many.json -q "${options[@]}" -o "$name" --format raw --concurrent 4 >"$name.log" 2>&1 &
  local job=$!
  for ((i = 0; i < 600; i++)); do
    [[ ! -e ${name}_00005.raw ]] && runs "$job" || break
    sleep 0.1
  done
  runs "$job" || { failed "$name: it ended by itself: $(cat "$name.log")"; return; }
  ranks=$(cat "/proc/$job/task"/*/children)
  $stop "$job" $ranks
  for ((i = 0; i < 300; i++)); do
    kill -0 "$job" 2>/dev/null || break
    sleep 0.1
  done
  if kill -0 "$job" 2>/dev/null; then
    failed "$name: still running after 30 s"
    kill -KILL "$job" $ranks
  fi
  wait "$job"
  status=$?
  ((status != 0)) || failed "$name: status 0"
  for file in "${name}"_*.raw; do
    pictures=$((pictures + 1))
    (($(stat -c %s "$file") == 160 * 120 * 16)) || failed "$file is not whole"
  done
  ((pictures >= 1 && pictures < 5000)) || failed "$name: $pictures pictures, expected some, but not all"
  for rank in $ranks; do
    for ((i = 0; i < 100; i++)); do
      runs "$rank" || break
      sleep 0.1
    done
    ! runs "$rank" || failed "$name: rank $rank is still there"
  done
  echo "$name: status $status, $pictures pictures"
}
kill_a_rank() { kill -KILL "$3"; }
interrupt() { kill -INT "$1"; }
stopped_by killed kill_a_rank
stopped_by interrupted interrupt
cat ./*.log
exit $((failures > 0))
