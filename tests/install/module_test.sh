#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# module_test.sh PREFIX MODULES - an installed server loads a module that was built outside of Galaxy's tree.
set -euo pipefail
prefix=$(realpath "$1") modules=$(realpath "$2")
folder=$(mktemp -d)
export XDG_RUNTIME_DIR=$folder/run OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -m 700 "$XDG_RUNTIME_DIR"
cd "$folder"
trap 'kill "$server" 2>/dev/null || true; rm -rf "$folder"' EXIT
cp "$modules/galaxy_example.so" .
"$prefix/bin/gxydata" radial -r 16 --array x ramp.vol >/dev/null
"$prefix/bin/gxyserver" --port 0 --port-file port --modules . --log-level warn >server.log 2>&1 &
server=$!
for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
result=$("$prefix/bin/msclient" -P "$(cat port)" -m data -m analysis -m example - <<'END'
import {"Datasets": {"name": "ramp", "filename": "ramp.vol", "type": "Volume"}};
example.range ramp;
make {"name": "upper", "filter": "Threshold", "inputs": {"source": "ramp"}, "least": 0, "largest": 1};
range upper;
quit;
END
)
wait "$server"
expected=$'  -1.0 1.0\n  upper, generation 1, type Volume\n  0.0 1.0'
[[ $result == "$expected" ]] || { printf 'got:\n%s\nexpected:\n%s\n' "$result" "$expected"; cat server.log; exit 1; }
