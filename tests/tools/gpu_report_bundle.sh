#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# gpu_report_bundle.sh BUNDLE_SH BUILD - the bundle as a user takes it to another machine: small, and enough without anything of
# this one's environment.
set -uo pipefail
shopt -s extglob
bundle=$(realpath "$1") build=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
failures=0
check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; failures=$((failures + 1)); fi
}

mkdir tools
printf '#!/bin/sh\necho "        libnowhere.so.1 => not found"\n' >tools/ldd
chmod +x tools/ldd
PATH=$folder/tools:$PATH "$bundle" "$build" incomplete.tar.gz >out.txt 2>error.txt
check ALibraryThatIsNotThereIsAnError test $? = 1
check ThatNamesIt grep -q libnowhere error.txt
check AndLeavesNoBundle test ! -e incomplete.tar.gz

check IsMade "$bundle" "$build" report.tar.gz
check IsBelow60MB test "$(stat -c %s report.tar.gz)" -lt 60000000
mkdir elsewhere
tar -C elsewhere -xzf report.tar.gz
cd elsewhere || exit 1
check HasAllThatItNeeds "$bundle" --check gpu-report
for library in gpu-report/lib/* gpu-report/system/*; do  # whichever is missing, it is named
  name=${library##*/}
  mv "$library" taken
  "$bundle" --check gpu-report 2>error.txt
  check "Without${name}ItIsFoundWanting" test $? = 1
  check AndItIsNamed grep -q "gpu-report: $name is missing, which .* needs$" error.txt
  mv taken "$library"
done
check HasNoneOfTheLibrariesThatOnlyOthersNeed test -z "$(compgen -G 'gpu-report/*/lib@(mpi|vtk|OpenImageIO)*')"
env -i gpu-report/run --device llvmpipe --scale 0.01 --minutes 2 --scenes 1 --pictures . >out.txt 2>&1
check RunsInAnEmptyEnvironment test $? = 0
check AndHasComparedAndTimed grep -Eq '^1 of 20 scenes compared, 0 do not agree; 4 of 4 benchmarks run, 0 failed' gpu-report.md
check InTenNumbersAndMore grep -Eq '^\| volume 32\^3 at 128\^2( \| [0-9][0-9.e+-]*){16} \|$' gpu-report.md
check EveryBenchmarkReadsSomething test "$(grep -Ec '^\|.* at 128\^2( \| [0-9][0-9.e+-]*){14} \| [0-9.e+-]*[1-9][0-9.e+-]* \| [0-9][0-9.e+-]* \|$' gpu-report.md)" = 4
check AndLeavesItsPictures cmp "smooth volume.device.raw" "smooth volume.embree.raw"
check AsFloatRgba test "$(stat -c %s "smooth volume.device.raw")" = $((192 * 160 * 16))
((failures == 0)) || cat out.txt
exit $((failures > 0))
