// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/sent_arrays.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/data/geometry_bytes.h"
#include "core/io/values_choice.h"

namespace gxy {

using insitu::Array;

namespace {

template <class T>
std::span<const T> spanOf(const SentArrays& sent, const SentArrays::Source& source, Array::What what) {
  const size_t array = sent.arrayOf(what);
  return {reinterpret_cast<const T*>(source.data(array)), size_t(source.counts[array])};
}

}  // namespace

insitu::Cells cellsOf(const SentArrays& sent, const SentArrays::Source& source) {
  if (source.counts.empty()) return {};
  return {source.points(), spanOf<uint8_t>(sent, source, Array::What::Types),
          spanOf<uint32_t>(sent, source, Array::What::Ends),
          spanOf<uint32_t>(sent, source, Array::What::Connectivity)};
}

void checkCells(const SentArrays& sent) {
  for (size_t r = 0; r < sent.sources().size(); r++) {
    const SentArrays::Source& source = sent.sources()[r];
    check(cellsOf(sent, source), sent.mesh().shape,
          "cells \"" + sent.mesh().name + "\", rank " + std::to_string(r) + " of the simulation",
          [&](size_t point) { return sent.position(source, point); });
  }
}

SentArrays::SentArrays(const insitu::Mesh& mesh, TakeStepMemory take, uint64_t morePerPoint)
    : mesh_(mesh),
      arrays_(arraysOf(mesh)),
      take_(std::move(take)),
      purpose_(mesh.shape == insitu::Mesh::Shape::Volume ? "volume" : "geometry"),
      morePerPoint_(morePerPoint) {}

size_t SentArrays::arrayOf(size_t field) const {
  return size_t(
      std::find_if(arrays_.begin(), arrays_.end(),
                   [&](const Array& a) { return a.what == Array::What::Field && a.field == field; }) -
      arrays_.begin());
}

size_t SentArrays::arrayOf(Array::What what) const {
  return size_t(std::find_if(arrays_.begin(), arrays_.end(), [&](const Array& a) { return a.what == what; }) -
                arrays_.begin());
}

void SentArrays::store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
                       std::span<const std::byte> samples) {
  if (sources_.size() <= size_t(piece.rank)) sources_.resize(size_t(piece.rank) + 1);
  Source& source = sources_[size_t(piece.rank)];
  if (header.offset == 0) {
    if (array == 0) {
      source = {};
      source.counts.resize(arrays_.size());
      source.arrays.resize(arrays_.size());
    }
    const uint64_t each = arrays_[array].bytesPerPoint() + (array == 0 ? morePerPoint_ : 0);
    source.memory.push_back(take(int64_t(header.points * each)));
    source.counts[array] = header.points;
    source.arrays[array].resize(header.points * arrays_[array].bytesPerPoint());
  }
  if (!samples.empty())
    std::memcpy(source.arrays[array].data() + header.offset, samples.data(), samples.size());
}

glm::dvec3 SentArrays::position(const Source& source, size_t point) const {
  const std::byte* positions = source.data(0);
  glm::dvec3 p;
  for (int a = 0; a < 3; a++) {
    const size_t at = 3 * point + size_t(a);
    p[a] = mesh_.positions == ScalarType::Float32 ? double(valueAt<float>(positions, at))
                                                  : valueAt<double>(positions, at);
  }
  return p;
}

std::map<int, uint64_t> firstNumbers(Collectives& ranks, std::span<const uint64_t> counts) {
  struct Count {
    int64_t rank;
    uint64_t count;
  };
  Bytes mine;
  for (size_t r = 0; r < counts.size(); r++) {
    const Count count{int64_t(r), counts[r]};
    if (count.count == 0) continue;
    const auto* bytes = reinterpret_cast<const std::byte*>(&count);
    mine.insert(mine.end(), bytes, bytes + sizeof count);
  }
  std::map<int, uint64_t> all;
  for (const Bytes& theirs : ranks.allGather(std::move(mine)))
    for (size_t i = 0; i < theirs.size() / sizeof(Count); i++) {
      const auto count = valueAt<Count>(theirs.data(), i);
      all[int(count.rank)] = count.count;
    }
  uint64_t next = 0;
  for (auto& [rank, count] : all) next += std::exchange(count, next);
  return all;
}

LookOf::LookOf(const insitu::Field& field) : type_(field.type), components_(field.components) {
  if (!isColors(field.name, field.type, field.components)) return;
  const bool isFraction = type_ == ScalarType::Float32 || type_ == ScalarType::Float64;
  full_ = isFraction ? 1 : type_ == ScalarType::UInt16 ? 65535 : 255;
}

void LookOf::append(const std::byte* values, size_t i, GeometryBlock& to) const {
  withType(type_, [&](auto type) {
    using T = decltype(type);
    const auto component = [&](int c) {
      return double(valueAt<T>(values, i * size_t(components_) + size_t(c)));
    };
    if (colored()) {
      glm::vec3 color(0);
      bool isFinite = true;
      for (int c = 0; c < 3; c++) {
        const double value = component(c) / full_;
        isFinite = isFinite && std::isfinite(value);
        color[c] = float(std::clamp(value, 0., 1.));
      }
      to.colors.push_back(isFinite ? color : glm::vec3(0));
    } else if (components_ == 1) {
      to.values.push_back(float(component(0)));
    } else {
      double sum = 0;
      for (int c = 0; c < components_; c++) sum += component(c) * component(c);
      to.values.push_back(float(std::sqrt(sum)));
    }
  });
}

std::shared_ptr<Dataset> datasetOf(const insitu::Mesh& mesh, const insitu::Field* field,
                                   OwnedGeometry geometry, const LedgerEntry& memory) {
  auto d = std::make_shared<Dataset>();
  if (field) d->array = field->name;
  geometry.name = field ? field->name : mesh.name;
  if (field) geometry.array = field->name;
  d->bytes = bytesOf(geometry.block);
  d->memory = memory.another(d->bytes);
  d->geometry = std::make_shared<const OwnedGeometry>(std::move(geometry));
  return d;
}

}  // namespace gxy
