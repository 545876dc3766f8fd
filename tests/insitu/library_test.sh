#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# library_test.sh LIBRARY PREFIX SYMBOL [OTHER] - a library that is loaded into programs of others needs the C and C++ libraries only, and
# OTHER. It exports SYMBOL, and names with PREFIX only.
set -euo pipefail
needed=$(readelf -d "$1" | sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p' | grep -vE "^(libc|libm|libstdc\+\+|libgcc_s|ld-linux.*${4:+|$4})\.so" || true)
[[ -z $needed ]] || { echo "needs $needed, expected libc, libm, libstdc++, libgcc_s ${4:+and $4 }only"; exit 1; }
others=$(nm -D --defined-only "$1" | awk '{ print $NF }' | grep -v "^$2" || true)
[[ -z $others ]] || { echo "exports $others, expected names that begin with $2 only"; exit 1; }
nm -D --defined-only "$1" | grep -q " $3\$" || { echo "does not export $3"; exit 1; }
