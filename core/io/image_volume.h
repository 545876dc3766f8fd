// SPDX-License-Identifier: Apache-2.0
// Turns images of files into volumes, which are grids along the axes of the world with samples on their
// points. Used inside core/io only.
#pragma once
#include <array>
#include <functional>

#include "core/io/volume_file.h"

namespace gxy {

/// An image as a file describes it. Point (i, j, k), counted from 0, lies at origin + direction *
/// (spacing * (i, j, k)).
struct ImageData {
  std::string path;
  Index3 points{1, 1, 1};  ///< per axis, at least 1
  glm::dvec3 origin{0}, spacing{1};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< by rows; column a: direction of axis a
  std::vector<ArrayInfo> arrays;                               ///< arrays of points and of cells
  std::string active, activeOfCells;                           ///< names of the active arrays; empty: none
  std::vector<std::string> warnings{};
  std::shared_ptr<Decoded> decoded = std::make_shared<Decoded>();

  /// The world position of an index, counted from the first point.
  glm::dvec3 placeOf(glm::dvec3 index) const;
  /// The number of cells per axis; an axis with one point has one cell.
  Index3 cells() const;
  /// The extent of an array's samples: all points or all cells.
  Extent extentOf(const ArrayInfo& array) const;
};

/// Opens an array of an image. The indices of the source are those of ImageData::extentOf().
using OpenArray = std::function<std::shared_ptr<const SampleSource>(const ArrayInfo& array)>;

/// Makes a volume of the array called `wanted`, where arrays of points come before those of cells. If `wanted`
/// is empty, it is the active array, or else the first. `open` is called for this array and for ghost arrays.
///
/// - If axes are flipped or exchanged (negative spacing, or a direction matrix that does this, within 1e-6), the
///   samples are reordered. An image that is rotated otherwise is turned about its centre to the nearest axes, with a
///   warning. Throws Error if its axes are not perpendicular within 1e-4.
/// - Samples of cells lie at the cells' centres, with the outermost layer repeated around them (Grid::rim).
/// - An axis with one point becomes an axis with two equal layers, one spacing apart, around the image's position. For
///   samples of cells it becomes an axis with one cell.
/// - Samples that the arrays "vtkGhostType" hide become NaN: points with the value 2, points whose cells all have 8 or
///   32, cells with 8 or 32, and cells that have a corner with 2. Integers become floating-point numbers for that.
VolumeFile volumeOf(const ImageData& image, const std::string& wanted, const OpenArray& open);

}  // namespace gxy
