#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# session_test.sh PREFIX VERSION - an installed tree, copied elsewhere, is all that is needed: every program tells its version,
# `galaxy serve` starts the server beside it, msdata imports, gxyviewer leaves a picture, the Python client another.
set -euo pipefail
prefix=$(realpath "$1") version=$2
folder=$(mktemp -d "$(dirname "$prefix")/session-XXXXXX")
server=
trap '[[ -z $server ]] || kill "$server" 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
cp -al "$prefix" "$folder/copied"
tree=$folder/copied
export PATH=$tree/bin:/usr/bin:/bin XDG_RUNTIME_DIR=$folder/run PYTHONPATH=$tree/lib/python3/dist-packages
mkdir -m 700 "$XDG_RUNTIME_DIR"
mkdir "$folder/work"
cd "$folder/work"
is() { [[ $2 == "$3" ]] || { printf '%s: "%s", expected "%s"\n' "$1" "$2" "$3"; exit 1; }; }

for program in gxyrender gxydata gxydiff gxybench gxyserver msdata msclient gxyviewer simsim gxysim galaxy; do
  is "$program --version" "$($program --version)" "$program $version"
done
is "gxy --version" "$(python3 -B -m gxy --version)" "gxy $version"
is "gxy.insitu" "$(python3 -B -c 'from gxy.insitu import Simulation; print(Simulation("heat").publish_last.__name__)')" publish_last
for file in galaxy_insitu.h galaxy_insitu.hpp galaxy_insitu_mpi.h galaxy_insitu.f90 galaxy_insitu_mpi.f90; do
  [[ -s $tree/include/galaxy/insitu/api/$file ]] || { echo "include/galaxy/insitu/api/$file is not installed"; exit 1; }
done
for file in README.md LICENSE docs/state-file.md examples/demo.json; do
  [[ -s $tree/share/doc/galaxy/$file ]] || { echo "share/doc/galaxy/$file is not installed"; exit 1; }
done

status=0
galaxy build 2>said || status=$?
is "status of galaxy build" "$status" 2
is "galaxy build" "$(cat said)" "galaxy: build: this is an installed Galaxy; build is a command of tools/galaxy in its sources"

gxydata radial -r 16 --array oneBall radial.vti >/dev/null
cat >scene.json <<'END'
{"Visualization": {"operators": [{"type": "Volume", "dataset": "ball", "isovalues": [0.5]}]},
 "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "aov": 40, "dimensions": [64, 64]}}
END
galaxy serve -n 1 --backend embree --port 0 --port-file port >server.log 2>&1 &
server=$!
for _ in $(seq 600); do [[ -s port ]] && break; sleep 0.1; done
port=$(cat port) || { cat server.log; exit 1; }
msdata -P "$port" -c 'import {"Datasets": {"name": "ball", "filename": "radial.vti", "type": "Volume"}}' >/dev/null
is "list" "$(msdata -P "$port" -c list | tr -s ' \n' ' ')" " datasets: ball "
gxyviewer -P "$port" scene.json --snapshot viewer.png
python3 -B -m gxy --server "localhost:$port" scene.json -o python.png
gxydiff viewer.png python.png --max 0.01
msdata -P "$port" -c quit >/dev/null
wait "$server"
server=
