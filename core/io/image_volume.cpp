// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/image_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gxy/comm/error.h"
#include "gxy/io/hidden_samples.h"
#include "gxy/io/lattice_samples.h"
#include "gxy/io/volume_description.h"
#include "gxy/io/volume_formats.h"

namespace gxy {
namespace {

constexpr const char* kGhosts = "vtkGhostType";

/// Which axis of the image runs along each axis of the world, and whether backwards.
struct Turn {
  std::array<size_t, 3> axis;
  std::array<bool, 3> backwards;
};

Turn turnOf(const ImageData& image) {
  constexpr double kRounding = 1e-6;
  Turn turn{{3, 3, 3}, {}};
  bool parallel = true;
  for (size_t w = 0; w < 3; ++w)
    for (size_t a = 0; a < 3; ++a) {
      const double d = image.direction[3 * w + a];
      if (std::abs(d) <= kRounding) continue;
      parallel = parallel && std::abs(std::abs(d) - 1) <= kRounding;
      turn.axis[w] = a;
      turn.backwards[w] = (d < 0) != (image.spacing[int(a)] < 0);
    }
  std::array<size_t, 3> sorted = turn.axis;
  std::sort(sorted.begin(), sorted.end());
  if (!parallel || sorted != std::array<size_t, 3>{0, 1, 2})
    throw Error(image.path +
                ": the image is rotated; read are images whose axes are parallel to those of the "
                "world, also backwards or in another order");
  return turn;
}

const ArrayInfo* ghostsAmong(const ImageData& image, bool ofCells) {
  for (const ArrayInfo& a : image.arrays)
    if (a.name == kGhosts && a.ofCells == ofCells && a.type == ScalarType::UInt8 && a.components == 1)
      return &a;
  return nullptr;
}

/// The spacing of an axis with one point, which may say nothing.
double thicknessOf(const ImageData& image, size_t axis) {
  const double own = std::abs(image.spacing[int(axis)]);
  if (own > 0 && std::isfinite(own)) return own;
  double least = std::numeric_limits<double>::infinity();
  for (size_t a = 0; a < 3; ++a)
    if (image.points[a] > 1) least = std::min(least, std::abs(image.spacing[int(a)]));
  return std::isfinite(least) ? least : 1;
}

/// What may be chosen, as chooseArray() takes it.
std::vector<ArrayInfo> choices(const ImageData& image) {
  std::vector<ArrayInfo> arrays;
  for (const bool ofCells : {false, true})
    for (const ArrayInfo& a : image.arrays)
      if (a.ofCells == ofCells && a.name != kGhosts) arrays.push_back(a);
  return arrays;
}

}  // namespace

glm::dvec3 ImageData::placeOf(glm::dvec3 index) const {
  glm::dvec3 place = origin;
  for (size_t w = 0; w < 3; ++w)
    for (size_t a = 0; a < 3; ++a)  // a direction that is 0 adds no rounding
      if (direction[3 * w + a] != 0 && index[int(a)] != 0)
        place[int(w)] += direction[3 * w + a] * spacing[int(a)] * index[int(a)];
  return place;
}

Index3 ImageData::cells() const {
  Index3 n;
  for (size_t a = 0; a < 3; ++a) n[a] = std::max<int64_t>(points[a] - 1, 1);
  return n;
}

Extent ImageData::extentOf(const ArrayInfo& array) const {
  return {{0, 0, 0}, array.ofCells ? cells() : points};
}

VolumeFile volumeOf(const ImageData& image, const std::string& wanted, const OpenArray& open) {
  VolumeFile file;
  file.path = image.path;
  file.warnings = image.warnings;
  file.decoded = image.decoded;
  file.arrays = choices(image);
  const bool anyOfPoints = !file.arrays.empty() && !file.arrays.front().ofCells;
  file.array = chooseArray(file.arrays, wanted, anyOfPoints ? image.active : image.activeOfCells, image.path);
  const bool ofCells = file.array.ofCells;
  const Turn turn = turnOf(image);
  const Extent stored = image.extentOf(file.array);

  LatticeSamples::Axes axes;
  for (size_t w = 0; w < 3; ++w) {
    const size_t a = turn.axis[w];
    const int64_t n = stored.points[a];
    const bool flat = image.points[a] == 1;
    const double h = flat ? thicknessOf(image, a) : std::abs(image.spacing[int(a)]);
    const double end = turn.backwards[w] ? -h * double(image.points[a] - 1) : 0;
    const double first = image.origin[int(w)] + end;  // of the image's points
    const int64_t layers = ofCells ? 2 : flat ? 1 : 0;
    file.grid.points[w] = n + layers;
    file.grid.spacing[int(w)] = h;
    file.grid.origin[int(w)] = ofCells && !flat ? first - h / 2
                               : ofCells        ? first - h
                               : flat           ? first - h / 2
                                                : first;
    axes[w] = {a, n, ofCells ? int64_t(1) : int64_t(0), turn.backwards[w]};
  }
  file.grid.rim = ofCells;
  checkGrid(file.grid, file.array.type, file.array.components, image.path);

  file.source = open(file.array);
  const ArrayInfo *points = ghostsAmong(image, false), *cells = ghostsAmong(image, true);
  if (points || cells) {
    const HiddenSamples::Ghosts ghosts{points ? open(*points) : nullptr, cells ? open(*cells) : nullptr,
                                       image.points, image.cells(), ofCells};
    file.source =
        std::make_shared<HiddenSamples>(file.source, file.array.type, file.array.components, ghosts);
    file.array.type = HiddenSamples::typeFor(file.array.type);
    file.array.range = {};
    file.heldPerPoint = sizeof(uint8_t);
  }
  if (!LatticeSamples::isIdentity(axes, file.grid.points))
    file.source = std::make_shared<LatticeSamples>(file.source, axes, file.bytesPerPoint());
  return file;
}

}  // namespace gxy
