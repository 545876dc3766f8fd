// SPDX-License-Identifier: Apache-2.0
#include "core/io/referenced_files.h"

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/image_header.h"
#include "core/io/volume_description.h"

namespace gxy {

std::vector<std::string> filesOpenedFor(const std::string& path) {
  const std::string extension = extensionOf(path);
  std::vector<std::string> files;
  if (extension == ".vol")
    files = {beside(path, parseVol(readText(path), path).rawFile)};
  else if (extension == ".json")
    files = {beside(path, parseVolumeJson(readText(path), path).rawFile)};
  else if (extension == ".mhd" || extension == ".mha" || extension == ".nhdr" || extension == ".nrrd") {
    if (const auto header = imageHeaderOf(path); header && !header->dataFile.empty())
      files = {beside(path, header->dataFile)};
  } else if (extension == ".pvti")
    files = xmlPieces(path, "PImageData");
  else if (extension == ".pvtu" || extension == ".pvtp" || extension == ".pvts" || extension == ".pvtr" ||
           extension == ".part")
    files = geometryPieces(path);
  if (files.size() > size_t(1) << 20)
    throw Error(path + ": it refers to " + std::to_string(files.size()) + " files, expected at most 2^20");
  files.insert(files.begin(), path);
  return files;
}

}  // namespace gxy
