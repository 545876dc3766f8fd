#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# library_test.sh LIBRARY - libgalaxy_insitu needs the C and C++ libraries only, and exports gxy_* only.
set -euo pipefail
needed=$(readelf -d "$1" | sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p' | grep -vE '^(libc|libm|libstdc\+\+|libgcc_s|ld-linux.*)\.so' || true)
[[ -z $needed ]] || { echo "needs $needed, expected libc, libm, libstdc++ and libgcc_s only"; exit 1; }
others=$(nm -D --defined-only "$1" | awk '{ print $NF }' | grep -v '^gxy_' || true)
[[ -z $others ]] || { echo "exports $others, expected names that begin with gxy_ only"; exit 1; }
nm -D --defined-only "$1" | grep -q ' gxy_publish$' || { echo "does not export gxy_publish"; exit 1; }
