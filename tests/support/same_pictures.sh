#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# same_pictures.sh SAME_PICTURES: tests the program that scripts use to compare pictures. It must notice a difference
# of one bit, and with --close a second differing pixel in a thousand, in colours and in depths.
set -uo pipefail
program=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
export TEST_TMPDIR=$folder/
failures=0
gives() {  # gives STATUS NAME ARGS...
  local status=$1 name=$2
  shift 2
  "$program" "$@" >out.txt 2>&1
  local found=$?
  if ((found == status)); then
    echo "ok: $name"
  else
    echo "FAILED: $name: status $found, expected $status"
    cat out.txt
    failures=$((failures + 1))
  fi
}
put() { printf '%b' "$3" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none; }  # put FILE AT BYTES
picture() {  # picture NAME: 40 x 25 zeros, and depths of 0
  head -c 16000 /dev/zero >"$1.raw"
  head -c 8000 /dev/zero >"$1.depth"
}
for name in expected same bit one two deep deeper; do picture "$name"; done
put bit.raw 0 '\x01'
put one.raw 0 '\x00\x00\x80\x3f'  # 1
put two.raw 0 '\x00\x00\x80\x3f'
put two.raw 16 '\x00\x00\x80\x3f'
put deep.depth 6 '\xf0\x3f'
put deeper.depth 6 '\xf0\x3f'
put deeper.depth 14 '\xf0\x3f'
gives 0 TheSame --size=40x25 expected.raw same.raw
gives 1 ABit --size=40x25 expected.raw bit.raw
gives 0 ABitIsClose --close --size=40x25 expected.raw bit.raw
gives 0 OnePixelInAThousandIsClose --close --size=40x25 expected.raw one.raw
gives 1 TwoAreNot --close --size=40x25 expected.raw two.raw
gives 1 ADepth --backend=embree --size=40x25 expected.raw deep.raw
gives 0 ADepthIsClose --close --size=40x25 expected.raw deep.raw
gives 1 TwoDepthsAreNot --close --size=40x25 expected.raw deeper.raw
rm deep.depth
gives 1 DepthsOfOneOnly --close --size=40x25 expected.raw deep.raw
head -c 7999 /dev/zero >deep.depth
gives 2 TooFewDepths --size=40x25 expected.raw deep.raw
gives 2 NoPicture --size=40x25 expected.raw nowhere.raw
gives 2 OnePicture expected.raw
exit $((failures > 0))
