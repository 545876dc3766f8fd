// SPDX-License-Identifier: Apache-2.0
#include "core/scene/dataset_type.h"

namespace gxy {

const char* nameOf(DatasetType type) {
  constexpr const char* kNames[kDatasetTypes] = {"Volume", "Particles", "PathLines", "Triangles"};
  return kNames[unsigned(type)];
}

std::optional<DatasetType> datasetTypeNamed(const std::string& name) {
  for (int i = 0; i < kDatasetTypes; i++)
    if (name == nameOf(DatasetType(i))) return DatasetType(i);
  return std::nullopt;
}

DatasetType typeOf(const Dataset& dataset) {
  if (dataset.volume || dataset.mesh) return DatasetType::Volume;
  switch (dataset.geometry->kind) {
    case GeometryKind::Particles:
      return DatasetType::Particles;
    case GeometryKind::PathLines:
      return DatasetType::PathLines;
    case GeometryKind::Triangles:
      break;
  }
  return DatasetType::Triangles;
}

std::optional<GeometryKind> geometryKindOf(DatasetType type) {
  switch (type) {
    case DatasetType::Volume:
      break;
    case DatasetType::Particles:
      return GeometryKind::Particles;
    case DatasetType::PathLines:
      return GeometryKind::PathLines;
    case DatasetType::Triangles:
      return GeometryKind::Triangles;
  }
  return std::nullopt;
}

}  // namespace gxy
