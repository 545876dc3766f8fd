#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# package_test.sh BUILD VERSION - CPack's Debian package names what it needs and holds the programs and what they open; its
# tarball holds the sources and nothing that was built.
set -euo pipefail
build=$(realpath "$1") version=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$build"
cpack -G DEB -B "$folder" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
package=("$folder"/galaxy_"$version"*.deb)
needs=$(dpkg-deb -f "${package[0]}" Depends)
for library in libopenimageio libvtk9 libembree libpng libopenmpi openmpi-bin; do
  [[ $needs == *"$library"* ]] || { echo "the package does not depend on $library, but on: $needs"; exit 1; }
done
dpkg-deb -c "${package[0]}" >"$folder/contents"
for file in bin/galaxy bin/gxyrender galaxy/libgalaxy_image.so galaxy/galaxy_viewer.so dist-packages/gxy/client.py; do
  grep -q "/usr/.*$file\$" "$folder/contents" || { echo "the package does not hold $file"; exit 1; }
done

cpack --config CPackSourceConfig.cmake -B "$folder" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
tar tzf "$folder/galaxy-$version.tar.gz" >"$folder/contents"
grep -q "^galaxy-$version/tools/galaxy\$" "$folder/contents"
if grep -E "^galaxy-$version/(build|\.git)/" "$folder/contents"; then exit 1; fi
