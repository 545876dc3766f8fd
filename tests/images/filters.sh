#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# filters.sh STATE GXYDATA GXYRENDER GXYSERVER MSCLIENT MPIEXEC... - the picture of a state file whose datasets filters make, seeds on an
# isosurface and lines of its gradient through them, is the same on 1, 2 and 4 ranks, in any number of partitions, and from a server.
set -uo pipefail
state=$(realpath "$1") gxydata=$2 gxyrender=$3 gxyserver=$4 msclient=$5
shift 5
mpiexec=("$@")
folder=$(mktemp -d)
server=
finish() {
  [[ -z $server ]] || kill "$server" 2>/dev/null
  rm -rf "$folder"
}
trap finish EXIT
cd "$folder" || exit 1
export XDG_RUNTIME_DIR=$folder
failures=0
check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; failures=$((failures + 1)); fi
}

"$gxydata" radial -r 24 radial.vti >/dev/null
# Files of a volume, of points and of lines, beside the picture.
outputs='"Outputs": [{"type": "Data file", "of": "gradient", "to": "NAME_gradient.vti"},
  {"type": "Data file", "of": "seeds", "to": "NAME_seeds.vtp"}, {"type": "Data file", "of": "lines", "to": "NAME_lines.vtu"}],'
sed 's/"rays per pixel": 4/"rays per pixel": 1/' "$state" >state.json
with_outputs() { { echo "{"; echo "${outputs//NAME/$1}"; tail -n +2 state.json; } >"$1.json"; }
same_files() { for file in gradient.vti seeds.vtp lines.vtu; do cmp "one_$file" "$1_$file" || return 1; done; }
render() { "$gxyrender" state.json --size 160x120 --threads 1 -q "$@"; }
check OneRank render -o one
with_outputs one
check OneRankWritesFiles "$gxyrender" one.json --size 16x12 --threads 1 -q -o files
for ranks in 2 4; do
  check "OnRanks$ranks" "${mpiexec[@]}" -n "$ranks" "$gxyrender" state.json --size 160x120 --threads 1 -q -o "ranks$ranks"
  with_outputs "ranks$ranks"
  check "FilesOnRanks$ranks" "${mpiexec[@]}" -n "$ranks" "$gxyrender" "ranks$ranks.json" --size 16x12 --threads 1 -q \
    --partitions 3,2,2 -o files
  check "RanksDoNotMatterToFiles$ranks" same_files "ranks$ranks"
  check "RanksDoNotMatter$ranks" cmp one_00000.png "ranks${ranks}_00000.png"
done
check InPartitions "${mpiexec[@]}" -n 3 "$gxyrender" state.json --size 160x120 --threads 1 -q --partitions 3,2,2 -o parts
check PartitionsDoNotMatter cmp one_00000.png parts_00000.png
sed '/"type": "PathLines", "dataset"/d' state.json >without.json
check WithoutLines "$gxyrender" without.json --size 160x120 --threads 1 -q -o without
check LinesAreSeen bash -c '! cmp -s one_00000.png without_00000.png'

"${mpiexec[@]}" -n 2 "$gxyserver" --port 0 --port-file port --data "$folder" --log-level warn >server.log 2>&1 &
server=$!
for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
sized=$(sed 's/"dimensions": \[480, 360\]/"dimensions": [160, 120]/' state.json)
check AServerMakesThem "$msclient" -P "$(cat port)" -m viewer -c "batch {\"state\": $sized, \"prefix\": \"served\"}" >reply.txt
check AServerRendersTheSame cmp one_00000.png served_00000.png
with_outputs served
check AGraphWritesFiles "$msclient" -P "$(cat port)" -m graph -c "graph.new g $(sed 's/"annotation": "[^"]*",//' served.json)" -c "graph.wait g" >graph.txt
check AServerWritesTheSame same_files served
"$msclient" -P "$(cat port)" -c quit >/dev/null 2>&1
wait "$server"
server=
((failures == 0)) || { cat reply.txt graph.txt server.log; exit 1; }
