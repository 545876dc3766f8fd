#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# galaxy_demo.sh GALAXY - the README's first session as tools/galaxy demo does it: twice, beside a server that runs already,
# without a display, and interrupted; and the session in situ, where simsim is built.
set -uo pipefail
galaxy=$(realpath "$1")
folder=$(mktemp -d)
export XDG_RUNTIME_DIR=$folder
unset DISPLAY
failures=0
other=
finish() {
  [[ -z $other ]] || kill -TERM "$other" 2>/dev/null
  wait
  rm -rf "$folder"
}
trap finish EXIT
check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; cat "$folder"/*.log; failures=$((failures + 1)); fi
}
tokens() { find "$folder" -name '*.token' | wc -l; }
# Processes whose environment has this test's run directory: servers and clients that it started.
left() { grep -lzxF "XDG_RUNTIME_DIR=$folder" /proc/[0-9]*/environ 2>/dev/null | xargs -r dirname | xargs -rn1 basename; }
running() { for pid in $(left); do cat "/proc/$pid/comm" 2>/dev/null; done | grep -cx "$1"; }
servers() { running gxyserver; }
demo() { "$galaxy" demo --built >"$folder/demo.log" 2>&1; }
picture() { sed -n 's/^galaxy: the picture: //p' "$folder/demo.log"; }

check TheFirstSessionEndsWell demo
check ItLeavesAPicture test -s "$(picture)"
check TheSecondClientSeesTheDataOfTheFirst grep -q '^      balls$' "$folder/demo.log"
check NothingRunsAfterwards test "$(servers)" = 0 -a "$(tokens)" = 0
first=$(cksum <"$(picture)")

if [[ -x $(dirname "$galaxy")/../build/release/bin/simsim ]]; then
  insitu() { "$galaxy" demo insitu --built >"$folder/insitu.log" 2>&1; }
  check PicturesOfASimulationAreThoseOfItsFiles insitu
  check TheServerAndTheSimulationHaveEnded test "$(servers)$(running simsim)$(tokens)" = 000
else
  echo "left out: the session in situ, since the release build has no simsim"
fi

"$galaxy" serve --port 0 --port-file "$folder/port" >"$folder/other.log" 2>&1 &
other=$!
for _ in $(seq 300); do [[ -s $folder/port ]] && break; sleep 0.1; done
check AServerThatRunsAlreadyIsNotInItsWay demo
check AndItMakesTheSamePictureAgain test "$(cksum <"$(picture)")" = "$first"
check TheOtherServerStillRuns test "$(servers)" = 1 -a "$(tokens)" = 2  # one is view-only
kill -TERM "$other"
wait "$other"
other=

for signal in INT TERM; do
  set -m  # as from a terminal: in the foreground of a process group
  "$galaxy" demo --built >"$folder/demo.log" 2>&1 &
  run=$!
  set +m
  for _ in $(seq 300); do (($(servers) == 2)) && break; sleep 0.05; done
  kill "-$signal" -- "-$run"
  wait "$run"
  check "Signal${signal}EndsItWithStatus130" test $? = 130
  for _ in $(seq 50); do (($(servers) == 0)) && break; sleep 0.1; done
  check "Signal${signal}LeavesNothingBehind" test "$(servers)" = 0 -a "$(tokens)" = 0
done
exit $((failures > 0))
