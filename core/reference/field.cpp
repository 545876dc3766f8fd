// SPDX-License-Identifier: Apache-2.0
#include "core/reference/field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/comm/error.h"
#include "core/reference/cubic.h"

namespace gxy::reference {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class T>
double load(const std::byte* samples, int64_t index) {
  T x;
  std::memcpy(&x, samples + index * int64_t(sizeof(T)), sizeof(T));
  return double(x);
}

size_t sizeOf(ScalarType type) {
  switch (type) {
    case ScalarType::Int8:
    case ScalarType::UInt8:
      return 1;
    case ScalarType::Int16:
    case ScalarType::UInt16:
      return 2;
    case ScalarType::Int32:
    case ScalarType::UInt32:
    case ScalarType::Float32:
      return 4;
    default:
      return 8;
  }
}

}  // namespace

double trilinear(const CellCorners& c, glm::dvec3 w) {
  const double y0 = mix(mix(c[0], c[1], w.x), mix(c[2], c[3], w.x), w.y);
  const double y1 = mix(mix(c[4], c[5], w.x), mix(c[6], c[7], w.x), w.y);
  return mix(y0, y1, w.z);
}

Field::Field(std::shared_ptr<const Volume> volume, std::optional<int> component)
    : volume_(std::move(volume)), bricks_(volume_->grid.points) {
  const auto found = volume_->blocks.find(0);
  if (found == volume_->blocks.end() || found->second.extent.first != Index3{0, 0, 0} ||
      found->second.extent.points != volume_->grid.points) {
    throw Error("reference: volume '" + volume_->name +
                "' is cut: expected one partition that holds its whole grid");
  }
  const VolumeBlock& block = found->second;
  if (block.samples.size() < bricks_.count() * volume_->components * sizeOf(volume_->stored)) {
    throw Error("reference: volume '" + volume_->name + "' holds fewer samples than its grid has points");
  }
  if (component && (*component < 0 || *component >= volume_->components)) {
    throw Error("reference: volume '" + volume_->name + "' has no component " + std::to_string(*component) +
                ": expected 0 to " + std::to_string(volume_->components - 1));
  }
  samples_ = block.samples.data();
  component_ = component ? *component : volume_->components == 1 ? 0 : -1;
}

double Field::smallestSpacing() const {
  const glm::dvec3 h = grid().spacing;
  return std::min({h.x, h.y, h.z});
}

double Field::stored(int64_t index) const {
  switch (volume_->stored) {
    case ScalarType::Int8:
      return load<int8_t>(samples_, index);
    case ScalarType::UInt8:
      return load<uint8_t>(samples_, index);
    case ScalarType::Int16:
      return load<int16_t>(samples_, index);
    case ScalarType::UInt16:
      return load<uint16_t>(samples_, index);
    case ScalarType::Int32:
      return load<int32_t>(samples_, index);
    case ScalarType::UInt32:
      return load<uint32_t>(samples_, index);
    case ScalarType::Int64:
      return load<int64_t>(samples_, index);
    case ScalarType::UInt64:
      return load<uint64_t>(samples_, index);
    case ScalarType::Float32:
      return load<float>(samples_, index);
    case ScalarType::Float64:
      return load<double>(samples_, index);
  }
  return kNaN;
}

double Field::sample(int64_t i, int64_t j, int64_t k) const {
  const Index3& n = grid().points;
  if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) return kNaN;
  const int64_t first = int64_t(bricks_(i, j, k)) * volume_->components;
  double x = 0;
  if (component_ >= 0) {
    x = volume_->shift + volume_->scale * stored(first + component_);
  } else {
    for (int c = 0; c < volume_->components; c++) {
      const double part = volume_->shift + volume_->scale * stored(first + c);
      x += part * part;
    }
    x = std::sqrt(x);
  }
  return std::isfinite(x) ? x : kNaN;
}

std::optional<CellCorners> Field::corners(const Index3& cell) const {
  CellCorners c;
  for (int n = 0; n < 8; n++) {
    c[n] = sample(cell[0] + (n & 1), cell[1] + (n >> 1 & 1), cell[2] + (n >> 2));
    if (std::isnan(c[n])) return std::nullopt;
  }
  return c;
}

Field::Place Field::locate(glm::dvec3 world) const {
  constexpr double kSlack = 1e-9;  // cells
  const Grid& g = grid();
  Place place{{}, {}, true};
  for (int a = 0; a < 3; a++) {
    const double x = (world[a] - g.origin[a]) / g.spacing[a];
    const double last = double(g.points[a] - 1);
    if (!(x >= -kSlack && x <= last + kSlack)) place.inside = false;
    place.cell[a] = std::clamp<int64_t>(int64_t(std::floor(std::clamp(x, 0.0, last))), 0, g.points[a] - 2);
    place.fraction[a] = std::clamp(x - double(place.cell[a]), 0.0, 1.0);
  }
  return place;
}

std::optional<double> Field::value(glm::dvec3 world) const {
  const Place place = locate(world);
  if (!place.inside) return std::nullopt;
  const auto c = corners(place.cell);
  if (!c) return std::nullopt;
  return trilinear(*c, place.fraction);
}

double Field::difference(Index3 p, int axis) const {
  Index3 before = p, after = p;
  before[axis]--;
  after[axis]++;
  const double here = sample(p[0], p[1], p[2]), h = grid().spacing[axis];
  const double lower = sample(before[0], before[1], before[2]), upper = sample(after[0], after[1], after[2]);
  if (std::isnan(lower)) return std::isnan(upper) ? 0 : (upper - here) / h;
  return std::isnan(upper) ? (here - lower) / h : (upper - lower) / (2 * h);
}

glm::dvec3 Field::smoothGradient(glm::dvec3 world) const {
  const Place place = locate(world);
  glm::dvec3 gradient;
  double most = 0;
  for (int a = 0; a < 3; a++) {
    CellCorners c;
    for (int n = 0; n < 8; n++) {
      c[n] = difference({place.cell[0] + (n & 1), place.cell[1] + (n >> 1 & 1), place.cell[2] + (n >> 2)}, a);
    }
    for (double d : c) most = std::max(most, std::abs(d));
    gradient[a] = trilinear(c, place.fraction);
  }
  const double left = std::max({std::abs(gradient.x), std::abs(gradient.y), std::abs(gradient.z)});
  return left <= 1e-5 * most ? glm::dvec3(0) : gradient;
}

glm::dvec3 Field::cellGradient(const Index3& cell, glm::dvec3 world) const {
  auto c = corners(cell);
  if (!c) return glm::dvec3(0);
  const double offset = (*c)[0];
  for (double& value : *c) value -= offset;
  glm::dvec3 inside, gradient;
  for (int a = 0; a < 3; a++)
    inside[a] = std::clamp((world[a] - grid().origin[a]) / grid().spacing[a] - double(cell[a]), 0.0, 1.0);
  for (int a = 0; a < 3; a++) {
    glm::dvec3 lower = inside, upper = inside;
    lower[a] = 0;
    upper[a] = 1;
    gradient[a] = (trilinear(*c, upper) - trilinear(*c, lower)) / grid().spacing[a];
  }
  return gradient;
}

}  // namespace gxy::reference
