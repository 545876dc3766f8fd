// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/gathering.h"

#include <algorithm>
#include <filesystem>

#include "core/data/gather.h"
#include "core/data/geometry_bytes.h"

namespace gxy {

int64_t gatheringBytes(const Dataset& dataset, bool root) {
  if (dataset.volume) {
    const int64_t slice = gatheredSliceBytes(*dataset.volume);
    return 2 * std::min(std::max(kSlabBytes, slice), slice * gatheredPoints(dataset.volume->grid)[2]);
  }
  const int64_t own = bytesOf(dataset.geometry->block);
  constexpr int64_t kPrimitive = 200;  // its points with all that they may have, and its indices
  int64_t floats = 0;                  // of further fields at each of at most three points
  for (const PointFieldInfo& f : dataset.geometry->fields) floats += f.components;
  const int64_t primitive = kPrimitive + 3 * floats * int64_t(sizeof(float));
  return root ? own + 3 * primitive * int64_t(dataset.geometry->primitives) : own;
}

std::string arrayName(const Dataset& dataset) {
  if (dataset.geometry && !dataset.geometry->array.empty()) return dataset.geometry->array;
  if (!dataset.array.empty()) return dataset.array;
  std::string name = dataset.volume ? dataset.volume->name : dataset.geometry->name;
  if (!dataset.file.empty()) {  // FILE:ARRAY of a volume, FILE of geometry
    const size_t file = std::filesystem::path(dataset.file).stem().string().size();
    name = name.size() > file ? name.substr(file + 1) : "";
  }
  return name.empty() ? "data" : name;
}

}  // namespace gxy
