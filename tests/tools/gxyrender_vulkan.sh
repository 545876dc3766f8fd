#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# gxyrender_vulkan.sh GALAXY BIN DEVICE - gxyrender as a program with the vulkan backend, on two ranks: the pictures are Embree's.
set -uo pipefail
galaxy=$(realpath "$1") bin=$(realpath "$2") device=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
failures=0
check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; cat ./*.log; failures=$((failures + 1)); fi
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
check TheSamePicture "$bin/gxydiff" embree_00000.exr vulkan_00000.exr
"$bin/gxyrender" scene.json -o wrong --backend vulkan --device nosuch >wrong.log 2>&1
check ADeviceThatIsNotThereIsAnError test $? = 1
exit $((failures > 0))
