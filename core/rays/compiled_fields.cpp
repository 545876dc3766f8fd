// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_fields.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

namespace {

// The largest kernel velocity is near 2^30, and steps are at most 2^40 long: speeds down to 2^-60 count, and
// no square leaves float's range (kernels/advect.h).
constexpr int kLargestVelocity = 30;
// Factors stay far from the ends of float's range.
constexpr int kLeastScale = -110, kLargestScale = 110;

std::string sizeText(const Grid& g) {
  return std::to_string(g.points[0]) + " x " + std::to_string(g.points[1]) + " x " +
         std::to_string(g.points[2]);
}

void checkAlike(const Volume& first, const Volume& other) {
  if (!(first.grid == other.grid))
    throw Error("volume \"" + other.name + "\" (" + sizeText(other.grid) +
                " points) is not on the grid of the vectors \"" + first.name + "\" (" + sizeText(first.grid) +
                " points); resample it to that grid, or interpolate it at the lines' points afterwards");
  const bool alike =
      first.blocks.size() == other.blocks.size() &&
      std::equal(first.blocks.begin(), first.blocks.end(), other.blocks.begin(),
                 [](auto& a, auto& b) { return a.first == b.first && a.second.extent == b.second.extent; });
  if (!alike)
    throw Error("volume \"" + other.name + "\" is cut otherwise than the vectors \"" + first.name +
                "\"; import both with one partitioning");
}

// Returns n so that 2^n is at most x, and 0 for what has no logarithm.
int exponentOf(double x) { return x > 0 && std::isfinite(x) ? std::ilogb(x) : 0; }

FlowUnits unitsOf(const Volume& v) {
  FlowUnits units;
  double fastest = 0, scales[3], largestCell = 0;
  for (int a = 0; a < 3; a++) {
    const Range range = size_t(a) < v.ranges.size() ? v.ranges[size_t(a)] : Range{};
    const double most = range.empty() ? 0 : std::max(std::abs(range.min), std::abs(range.max));
    fastest = std::max(fastest, most / v.grid.spacing[a]);
    scales[a] = v.scale / v.grid.spacing[a];
    largestCell = std::max(largestCell, v.grid.spacing[a]);
  }
  int exponent = kLargestVelocity - exponentOf(fastest);
  const double least = std::min({scales[0], scales[1], scales[2]});
  const double most = std::max({scales[0], scales[1], scales[2]});
  exponent = std::max(std::min(exponent, kLargestScale - exponentOf(most)), kLeastScale - exponentOf(least));
  units.time = std::ldexp(1.0, exponent);
  units.length = std::ldexp(1.0, exponentOf(largestCell));
  for (int a = 0; a < 3; a++) {
    units.scale[size_t(a)] = float(scales[a] * units.time);
    units.shift[size_t(a)] = float(v.shift / v.grid.spacing[a] * units.time);
    units.spacing[size_t(a)] = float(v.grid.spacing[a] / units.length);
  }
  return units;
}

}  // namespace

CompiledFields::CompiledFields(std::vector<std::shared_ptr<const Volume>> volumes,
                               std::shared_ptr<const Partitioning> partitioning)
    : volumes_(std::move(volumes)), partitioning_(std::move(partitioning)) {
  if (volumes_.empty() || volumes_.size() > kMostFields)
    throw Error("lines read " + std::to_string(volumes_.size()) + " volumes; expected 1 to " +
                std::to_string(kMostFields));
  const Volume& first = *volumes_.front();
  if (first.components != 3)
    throw Error("volume \"" + first.name + "\" has " + std::to_string(first.components) +
                " components; lines need vectors of 3: compose them of scalars by \"[u, v, w]\"");
  for (int a = 0; a < 3; a++)
    if (first.grid.points[size_t(a)] > int64_t(1) << 30)
      throw Error("volume \"" + first.name + "\" has more than 2^30 points along an axis");
  for (size_t v = 1; v < volumes_.size(); v++) {
    checkAlike(first, *volumes_[v]);
    for (int c = 0; c < volumes_[v]->components; c++) recorded_.push_back({int(v), c});
  }
  units_ = unitsOf(first);
  const Box& domain = partitioning_->domain();
  for (int a = 0; a < 3; a++) {
    const auto faces = partitioning_->faces(a);
    auto& lattice = lattice_[size_t(a)];
    lattice.resize(size_t(grid().cells()[size_t(a)]));
    for (size_t i = 0; i < lattice.size(); i++) {
      const double centre = grid().origin[a] + grid().spacing[a] * (double(i) + 0.5);
      const double inside = std::clamp(centre, domain.lo[a], domain.hi[a]);
      const auto above = std::upper_bound(faces.begin(), faces.end(), inside) - faces.begin();
      lattice[i] = int32_t(std::clamp<int64_t>(above - 1, 0, int64_t(faces.size()) - 2));
    }
  }
}

int CompiledFields::partitionOf(const Index3& cell) const {
  const std::array<int, 3> n = partitioning_->cells();
  const auto at = [&](size_t a) { return size_t(lattice_[a][size_t(cell[a])]); };
  return partitioning_->cellPartition()[(at(2) * size_t(n[1]) + at(1)) * size_t(n[0]) + at(0)];
}

const Extent* CompiledFields::extentOf(int partition) const {
  const auto found = vectors().blocks.find(partition);
  return found == vectors().blocks.end() ? nullptr : &found->second.extent;
}

bool CompiledFields::locate(glm::dvec3 world, Place& place) const {
  constexpr double kSlack = 1e-9;
  const double rim = grid().rim ? 0.5 : 0;
  for (int a = 0; a < 3; a++) {
    const double last = double(grid().points[size_t(a)] - 1);
    const double x = (world[a] - grid().origin[a]) / grid().spacing[a];
    if (!(x >= rim - kSlack && x <= last - rim + kSlack)) return false;
    const double inside = std::clamp(x, rim, last - rim);
    const double cell = std::min(std::floor(inside), last - 1);
    place.cell[size_t(a)] = int64_t(cell);
    place.fraction[a] = float(inside - cell);
  }
  return true;
}

size_t CompiledFields::bytes() const {
  size_t n = 0;
  for (const auto& l : lattice_) n += l.size() * sizeof(int32_t);
  return n;
}

}  // namespace gxy
