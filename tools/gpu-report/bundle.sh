#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/gpu-report/bundle.sh [BUILD] [OUTPUT.tar.gz] - packs gpu_report with the libraries that it needs. On the other machine,
# of the same processor family, with a GPU's driver and a C library as new as this one's:
#
#   tar xzf gpu-report.tar.gz && gpu-report/run            # writes gpu-report.md; options as of gpu_report --help
#
# tools/gpu-report/bundle.sh --check FOLDER - whether an unpacked bundle has all that its program and libraries need but the C
# library's family; names what is missing (exit status 1). Every bundle that is made is so checked.
#
# Libraries that belong to a system (C++ run time, Vulkan loader) are taken from the bundle only where there are none.
set -euo pipefail

is_c_library() {
  case $1 in
    ld-linux*.so.* | libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.*) ;;
    *) return 1 ;;
  esac
}

check() {  # check FOLDER
  local file name needed missing=0
  for file in "$1/gpu_report" "$1"/lib/* "$1"/system/*; do
    [[ -e $file ]] || continue  # of an empty folder
    needed=$(readelf -d "$file")
    for name in $(sed -n 's/.*(NEEDED).*\[\(.*\)\]$/\1/p' <<<"$needed"); do
      is_c_library "$name" || [[ -e $1/lib/$name || -e $1/system/$name ]] || {
        echo "$1: $name is missing, which ${file#"$1"/} needs" >&2
        missing=1
      }
    done
  done
  return $missing
}

if [[ ${1:-} == --check ]]; then
  [[ -e ${2:?--check FOLDER}/gpu_report ]] || { echo "$2: there is no gpu_report" >&2; exit 1; }
  check "$2"
  exit
fi
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/release}
output=${2:-gpu-report.tar.gz}
program=$build/bin/gpu_report
[ -x "$program" ] || { echo "$program is not there: cmake --build $build --target gpu_report" >&2; exit 1; }

libraries=$(ldd "$program")
if grep 'not found' <<<"$libraries" >&2; then
  echo "$program needs what is not on this machine: build it here" >&2
  exit 1
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/gpu-report/lib" "$work/gpu-report/system"
cp "$program" "$work/gpu-report/"
strip "$work/gpu-report/gpu_report"
awk '$3 ~ /^\// { print $1, $3 }' <<<"$libraries" | while read -r name path; do
  is_c_library "$name" && continue
  case $name in
    libstdc++.so.* | libgcc_s.so.* | libvulkan.so.*) cp -L "$path" "$work/gpu-report/system/$name" ;;
    *) cp -L "$path" "$work/gpu-report/lib/$name" && strip "$work/gpu-report/lib/$name" ;;
  esac
done
cat >"$work/gpu-report/run" <<'RUN'
#!/bin/sh
# Runs gpu_report with its own libraries, and with those of a system where the system has none.
here=$(cd "$(dirname "$0")" && pwd)
libraries=$here/lib
missing=$(mktemp -d)
trap 'rm -rf "$missing"' EXIT
for file in "$here"/system/*; do
  name=${file##*/}
  for folder in /lib /lib64 /usr/lib /usr/lib64 /lib/*-linux-gnu /usr/lib/*-linux-gnu /usr/local/lib; do
    [ -e "$folder/$name" ] && continue 2
  done
  ln -s "$file" "$missing/$name"
done
LD_LIBRARY_PATH=$libraries:$missing${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} "$here/gpu_report" "$@"
RUN
chmod +x "$work/gpu-report/run"
check "$work/gpu-report"
tar -C "$work" -czf "$output" gpu-report
echo "$output: $(du -h "$output" | cut -f1), unpacked $(du -sh "$work/gpu-report" | cut -f1)"
