// SPDX-License-Identifier: Apache-2.0
#include "core/look/loaded_facts.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "core/data/bricks.h"

namespace gxy {

DataFacts factsOf(const Volume& volume) {
  const Box box = volume.grid.box();
  return {box, box, volume.ranges, 0, {}};
}

DataFacts factsOf(const Mesh& mesh) { return {mesh.box, mesh.box, mesh.ranges, 0, {}}; }

DataFacts factsOf(const OwnedGeometry& geometry) {
  DataFacts facts{geometry.box, geometry.middle, {geometry.range}, geometry.spacing, {}};
  for (const PointFieldInfo& f : geometry.fields)
    if (f.name != geometry.array || f.components > 1) facts.fields[f.name] = f.ranges;
  return facts;
}

DataFacts factsOf(const Dataset& dataset) {
  return dataset.volume ? factsOf(*dataset.volume)
         : dataset.mesh ? factsOf(*dataset.mesh)
                        : factsOf(*dataset.geometry);
}

double shownValue(const std::byte* sample, ScalarType type, int components) {
  const auto component = [&](int c) {
    return withType(type, [&](auto kind) {
      decltype(kind) value;
      std::memcpy(&value, sample + size_t(c) * sizeof value, sizeof value);
      return double(value);
    });
  };
  if (components == 1) return component(0);
  double sum = 0;
  for (int c = 0; c < components; c++) sum += component(c) * component(c);
  return std::sqrt(sum);
}

std::optional<int> thinAxis(const Grid& grid) {
  std::optional<int> thin;
  for (int a = 0; a < 3; a++) {
    if (grid.points[size_t(a)] > 2) continue;
    if (thin) return std::nullopt;
    thin = a;
  }
  return thin;
}

Index3 samplingStride(const Grid& grid) {
  Index3 stride;
  for (size_t a = 0; a < 3; a++) stride[a] = (grid.points[a] + kSampledPerAxis - 1) / kSampledPerAxis;
  return stride;
}

std::vector<float> sampleOf(const Volume& volume, const Partitioning& partitioning) {
  const Index3 stride = samplingStride(volume.grid);
  const size_t each = bytesOf(volume.stored) * size_t(volume.components);
  const double shift = volume.components == 1 ? volume.shift : 0;  // several components are not shifted
  std::vector<float> values;
  for (const auto& [partition, block] : volume.blocks) {
    const Extent own = ownedPoints(volume.grid, partitioning, partition);
    const Bricks place(block.extent.points);
    const auto first = [&](size_t a) { return (own.first[a] + stride[a] - 1) / stride[a] * stride[a]; };
    const auto end = [&](size_t a) { return own.first[a] + own.points[a]; };
    for (int64_t k = first(2); k < end(2); k += stride[2])
      for (int64_t j = first(1); j < end(1); j += stride[1])
        for (int64_t i = first(0); i < end(0); i += stride[0]) {
          const Index3& from = block.extent.first;
          const std::byte* sample =
              block.samples.data() + place(i - from[0], j - from[1], k - from[2]) * each;
          const double value = shift + volume.scale * shownValue(sample, volume.stored, volume.components);
          if (std::isfinite(value)) values.push_back(float(value));
        }
  }
  return values;
}

namespace {

/// A number that looks random, and that a place alone decides.
uint64_t drawnAt(const glm::dvec3& place) {
  uint64_t drawn = 0;
  for (int a = 0; a < 3; a++) {
    drawn = (drawn ^ std::bit_cast<uint64_t>(place[a])) * 0x9e3779b97f4a7c15;
    drawn ^= drawn >> 32;
  }
  return drawn;
}

}  // namespace

std::vector<float> sampleOf(const Mesh& mesh, const Partitioning& partitioning) {
  std::vector<float> values;
  const uint64_t stride = mesh.report.points / kSampledValues + 1;
  const auto components = size_t(mesh.components);
  for (const auto& [partition, block] : mesh.blocks)
    for (size_t p = 0; p < block.points.size(); p++) {
      if (stride > 1 && drawnAt(block.points[p]) % stride != 0) continue;
      if (partitioning.nearest(block.points[p]) != partition) continue;
      const double value =
          mesh.shift +
          mesh.scale * shownValue(reinterpret_cast<const std::byte*>(block.values.data() + p * components),
                                  ScalarType::Float32, mesh.components);
      if (std::isfinite(value)) values.push_back(float(value));
    }
  return values;
}

std::vector<float> sampleOf(const OwnedGeometry& geometry) {
  std::vector<float> values;
  const GeometryBlock& block = geometry.block;
  if (block.values.empty()) return values;
  const uint64_t stride = geometry.primitives / kSampledValues + 1;
  for (size_t p = 0; p < block.ids.size(); p++) {
    const float value = block.values[*primitivePoints(block, geometry.kind, p).begin()];
    if (block.ids[p] % stride == 0 && std::isfinite(value)) values.push_back(value);
  }
  return values;
}

std::vector<float> sampleOf(const Dataset& dataset) {
  return dataset.volume ? sampleOf(*dataset.volume, *dataset.partitioning)
         : dataset.mesh ? sampleOf(*dataset.mesh, *dataset.partitioning)
                        : sampleOf(*dataset.geometry);
}

}  // namespace gxy
