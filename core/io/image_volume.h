// SPDX-License-Identifier: Apache-2.0
// Images, as files have them, become volumes: grids whose axes are those of the world, with samples on their points. Used inside
// core/io only.
#pragma once
#include <array>
#include <functional>

#include "core/io/volume_file.h"

namespace gxy {

/// What a file says of an image. Point (i, j, k), counted from 0, lies at origin + direction * (spacing * (i, j, k)).
struct ImageData {
  std::string path;
  Index3 points{1, 1, 1};  ///< per axis, at least 1
  glm::dvec3 origin{0}, spacing{1};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row: column a is where axis a goes
  std::vector<ArrayInfo> arrays;                               ///< of points and of cells
  std::string active, activeOfCells;                           ///< names of arrays; empty: none
  std::vector<std::string> warnings{};
  std::shared_ptr<Decoded> decoded = std::make_shared<Decoded>();

  /// Where an index, counted from the first point, lies.
  glm::dvec3 placeOf(glm::dvec3 index) const;
  /// Cells per axis; an axis with one point has one.
  Index3 cells() const;
  /// The extent of an array.
  Extent extentOf(const ArrayInfo& array) const;
};

/// Opens an array of an image; the indices of what it returns are those of ImageData::extentOf().
using OpenArray = std::function<std::shared_ptr<const SampleSource>(const ArrayInfo& array)>;

/// The volume of the array called `wanted` (of points before cells), else the active one, else the first. `open` is called for it, and
/// for arrays that say what is hidden.
///
/// - Axes that are flipped or change their places (negative spacing, or a direction that is such a matrix to 1e-6) are put
///   right by reordering samples. An image that is rotated otherwise is turned about its centre to the nearest axes, with a
///   warning. Throws Error where its axes are not at right angles to 1e-4.
/// - Samples of cells stand at the cells' centres, with a layer repeated outside (Grid::rim).
/// - An axis with one point becomes one of two equal layers (of cells: one cell), one spacing apart, around where the image is.
/// - Samples that the arrays "vtkGhostType" hide are NaN: points with bit 2, points of which all cells have bit 32, cells with bit
///   32, cells of which a corner has bit 2. Integers become floating-point numbers for that.
VolumeFile volumeOf(const ImageData& image, const std::string& wanted, const OpenArray& open);

}  // namespace gxy
