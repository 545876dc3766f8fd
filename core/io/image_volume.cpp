// SPDX-License-Identifier: Apache-2.0
#include "core/io/image_volume.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "core/comm/error.h"
#include "core/io/hidden_samples.h"
#include "core/io/lattice_samples.h"
#include "core/io/volume_description.h"
#include "core/io/volume_formats.h"

namespace gxy {
namespace {

constexpr const char* kGhosts = "vtkGhostType";

constexpr double kRounding = 1e-6;

bool isAlongAxes(const std::array<double, 9>& direction) {
  return std::all_of(direction.begin(), direction.end(), [](double d) {
    return std::abs(d) <= kRounding || std::abs(std::abs(d) - 1) <= kRounding;
  });
}

/// Throws Error unless the axes of the image are perpendicular unit vectors, within the precision of
/// float in headers.
void checkPerpendicular(const ImageData& image) {
  constexpr double kFloats = 1e-4;
  const auto& d = image.direction;
  for (size_t a = 0; a < 3; ++a)
    for (size_t b = a; b < 3; ++b) {
      const double product = d[a] * d[b] + d[3 + a] * d[3 + b] + d[6 + a] * d[6 + b];
      if (!(std::abs(product - (a == b)) <= kFloats))
        throw Error(image.path + ": the axes of the image, expected to be at right angles, are not");
    }
}

double determinant(const std::array<double, 9>& d) {
  return d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) +
         d[2] * (d[3] * d[7] - d[4] * d[6]);
}

/// Returns the nearest matrix of directions along axes that has the same handedness, and its angle to
/// `direction` in degrees.
std::pair<std::array<double, 9>, double> nearestAlongAxes(const std::array<double, 9>& direction) {
  std::array<double, 9> nearest{};
  double best = -std::numeric_limits<double>::infinity();
  std::array<size_t, 3> order{0, 1, 2};  // by axis of the image: the axis of the world that it runs along
  do {
    for (int signs = 0; signs < 8; ++signs) {
      std::array<double, 9> candidate{};
      double trace = 0;
      for (size_t a = 0; a < 3; ++a) {
        const double sign = signs >> a & 1 ? -1 : 1;
        candidate[3 * order[a] + a] = sign;
        trace += sign * direction[3 * order[a] + a];
      }
      if (trace <= best || determinant(candidate) * determinant(direction) < 0) continue;
      best = trace;
      nearest = candidate;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return {nearest, std::acos(std::clamp((best - 1) / 2, -1.0, 1.0)) * 180 / std::numbers::pi};
}

/// Turns a rotated image about its centre to the nearest axes of the world, and adds a warning.
ImageData turnedToAxes(ImageData image) {
  checkPerpendicular(image);
  if (isAlongAxes(image.direction)) return image;
  const glm::dvec3 middle = 0.5 * glm::dvec3(image.points[0] - 1, image.points[1] - 1, image.points[2] - 1);
  const glm::dvec3 centre = image.placeOf(middle);
  const auto [nearest, degrees] = nearestAlongAxes(image.direction);
  image.direction = nearest;
  image.origin += centre - image.placeOf(middle);
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", degrees);
  image.warnings.push_back(
      image.path + ": the image is rotated by " + text +
      " degrees against the nearest axes of the world and is shown along these, about its "
      "centre: its place beside other data is not right");
  return image;
}

/// By axis of the world: the axis of the image that runs along it, and whether it runs backwards.
struct Turn {
  std::array<size_t, 3> axis;
  std::array<bool, 3> backwards;
};

Turn turnOf(const ImageData& image) {
  Turn turn{{3, 3, 3}, {}};
  for (size_t w = 0; w < 3; ++w)
    for (size_t a = 0; a < 3; ++a) {
      const double d = image.direction[3 * w + a];
      if (std::abs(d) <= kRounding) continue;
      turn.axis[w] = a;
      turn.backwards[w] = (d < 0) != (image.spacing[int(a)] < 0);
    }
  std::array<size_t, 3> sorted = turn.axis;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::array<size_t, 3>{0, 1, 2})
    throw Error(image.path + ": two axes of the image run along the same axis of the world");
  return turn;
}

const ArrayInfo* ghostsAmong(const ImageData& image, bool ofCells) {
  for (const ArrayInfo& a : image.arrays)
    if (a.name == kGhosts && a.ofCells == ofCells && a.type == ScalarType::UInt8 && a.components == 1)
      return &a;
  return nullptr;
}

/// Returns the spacing of an axis with one point. If the file gives none, it is the smallest spacing of the
/// other axes.
double thicknessOf(const ImageData& image, size_t axis) {
  const double own = std::abs(image.spacing[int(axis)]);
  if (own > 0 && std::isfinite(own)) return own;
  double least = std::numeric_limits<double>::infinity();
  for (size_t a = 0; a < 3; ++a)
    if (image.points[a] > 1) least = std::min(least, std::abs(image.spacing[int(a)]));
  return std::isfinite(least) ? least : 1;
}

/// Returns the arrays that may be chosen, in the order that chooseArray() expects.
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
    for (size_t a = 0; a < 3; ++a)  // Zeros are skipped, so that they add no rounding.
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

VolumeFile volumeOf(const ImageData& stated, const std::string& wanted, const OpenArray& open) {
  const ImageData image = turnedToAxes(stated);
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
    const double first = image.origin[int(w)] + end;  // world coordinate of the image's first point
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
