#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# vulkan_programs.sh GALAXY BIN DEVICE KEPT SAME_PICTURES - gxyrender and gxyserver as programs with the vulkan backend, on two ranks: the
# pictures are Embree's (bit for bit, but where DEVICE is a GPU); where one is not, both and their difference are left in folder KEPT. And where there is no such device,
# and no driver at all. Ends with all that the programs printed.
set -uo pipefail
galaxy=$(realpath "$1") bin=$(realpath "$2") device=$3 kept=$(realpath -m "$4") same_pictures=$(realpath "$5")
rm -rf "$kept"
folder=$(mktemp -d)
server=
trap '[[ -z $server ]] || { kill -TERM "$server"; wait "$server"; }; rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR=$folder/run
mkdir -m 700 "$XDG_RUNTIME_DIR"
cd "$folder" || exit 1
failures=0
check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; failures=$((failures + 1)); fi
}
export TEST_TMPDIR=$folder/
made_by=vulkan
same() {  # same NAME PICTURE: it is Embree's
  local name=$1 picture=$2
  "$same_pictures" --backend="$made_by" embree_00000.exr "$picture" && { echo "ok: $name"; return; }
  failures=$((failures + 1))
  mkdir -p "$kept"
  cp embree_00000.exr "$picture" "$kept"
  "$bin/gxydiff" embree_00000.exr "$picture" --output "$kept/${picture%.exr}_difference.png" >/dev/null
  printf 'FAILED: %s: see %s: %s\n' "$name" "$kept" "$(cd "$kept" && echo ./*)"
}

"$bin/gxyrender" --backend vulkan --list-devices >devices.log 2>&1
check ListsDevices test $? = 0
check AmongThemTheDevice grep -qi "^vulkan [0-9]*: .*$device" devices.log

"$bin/gxydata" radial -r 24 --array eightBalls eightBalls.vol >/dev/null
cat >scene.json <<'END'
{"Datasets": [{"name": "eightBalls", "type": "Volume", "filename": "eightBalls.vol"}],
 "Visualization": {"Lighting": {"shadows": true, "ao count": 2},
   "operators": [{"type": "Volume", "dataset": "eightBalls", "isovalues": [0.3]}]},
 "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "dimensions": [60, 45]}}
END
"$galaxy" run -n 2 "$bin/gxyrender" scene.json -o embree --backend embree --format exr >embree.log 2>&1
check EmbreeRenders test $? = 0
"$galaxy" run -n 2 "$bin/gxyrender" scene.json -o vulkan --backend vulkan --device "$device" --format exr >vulkan.log 2>&1
check VulkanRenders test $? = 0
if grep -q ': llvmpipe' <<<"$(grep -i "$device" devices.log)"; then
  check AndSaysOnceThatItIsSoftware test "$(grep -c 'llvmpipe.* is software' vulkan.log)" = 1
fi
same TheSamePicture vulkan_00000.exr

serve() {  # serve RANKS OPTIONS...: a server on a free port; sets server and port
  local ranks=$1
  shift
  rm -f port
  "$galaxy" run -n "$ranks" "$bin/gxyserver" --modules "$bin/../lib/galaxy" --port 0 --port-file port "$@" >server.log 2>&1 &
  server=$!
  for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
  port=$(cat port)
}
batch() {  # batch PREFIX: the scene, rendered by the server
  printf 'load data; import {"Datasets": [{"name": "eightBalls", "type": "Volume", "filename": "eightBalls.vol"}]};\n' >batch.txt
  printf 'load viewer; batch {"prefix": "%s", "format": "exr", "state": %s};\n' "$1" "$(tail -n +2 scene.json | sed '1s/^/{/')" >>batch.txt
  timeout 120 "$bin/msdata" -P "$port" batch.txt >"$1.log" 2>&1
}
stop() {
  "$bin/msdata" -P "$port" -c quit >quit.log 2>&1
  wait "$server"
  status=$?
  server=
}
serve 2 --backend vulkan --device "$device"
batch served
check AServerRenders test $? = 0
same TheSamePictureAgain served_00000.exr
stop
mv server.log vulkan_server.log
check AndStops test "$status" = 0

refuses() {  # refuses NAME WORDS COMMAND...: exit status 1, and one error with these words
  local name=$1 words=$2
  shift 2
  timeout 60 "$@" >"$name.log" 2>&1
  check "$name" test $? = 1
  check OneErrorSaysSo test "$(grep -c 'error: ' "$name.log")" = 1
  check InTheseWords grep -q "error: .*$words" "$name.log"
}
refuses ADeviceThatIsNotThere 'no Vulkan device "nosuch"; expected one of: ' \
  "$bin/gxyrender" scene.json -o wrong --backend vulkan --device nosuch
refuses ADeviceThatIsNotThereOfAServer 'no Vulkan device "nosuch"; expected one of: ' \
  "$bin/gxyserver" --no-token --port 0 --backend vulkan --device nosuch

made_by=embree
export VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null VK_INSTANCE_LAYERS=
refuses NoDriver 'no driver is installed' "$bin/gxyrender" scene.json -o wrong --backend vulkan
refuses NoDriverForAServer 'no driver is installed' "$bin/gxyserver" --no-token --port 0 --backend vulkan
check NothingIsWritten test -z "$(compgen -G 'wrong*')"
"$bin/gxyrender" scene.json -o auto --backend auto --format exr >auto.log 2>&1
check AutoDoesWithout test $? = 0
same WithTheSamePicture auto_00000.exr
serve 1 --backend auto
batch without
check AServerDoes test $? = 0
same WithTheSamePictureAgain without_00000.exr
check OnTheCpu grep -q 'rank 0: backend embree' server.log
stop
check AndStopsToo test "$status" = 0
cat ./*.log
exit $((failures > 0))
