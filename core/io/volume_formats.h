// SPDX-License-Identifier: Apache-2.0
// The readers behind openVolume(), one per format. Used inside core/io only.
#pragma once
#include <algorithm>

#include "core/io/volume_file.h"

namespace gxy {

VolumeFile openRawVolume(const std::string& path);                               ///< .vol .json
VolumeFile openImageFile(const std::string& path, const RawOptions& options);    ///< see image_header.h
VolumeFile openRaw(const std::string& path, const RawOptions& options);          ///< with dimensions and type
bool isImageFile(const std::string& path);                                       ///< by its ending
VolumeFile openVti(const std::string& path, const std::string& array);           ///< .vti
VolumeFile openPvti(const std::string& path, const std::string& array);          ///< .pvti
VolumeFile openLegacyVolume(const std::string& path, const std::string& array);  ///< .vtk

/// Returns the array called `name`; if that is empty, the one called `active`, or else the first. Throws
/// Error with a list of the arrays if there is none.
const ArrayInfo& chooseArray(const std::vector<ArrayInfo>& arrays, const std::string& name,
                             const std::string& active, const std::string& path);

/// Splits `count` points of `extent` from number `first` on, counted x fastest, into boxes in that order:
/// parts of rows, rows and slices. Calls use(box, n) for each; n is the number of the box's first point.
template <class Use>
void forBoxes(const Extent& extent, int64_t first, int64_t count, Use use) {
  const int64_t row = extent.points[0], slice = row * extent.points[1];
  while (count > 0) {
    const int64_t x = first % row, y = first % slice / row, z = first / slice;
    Extent box{{extent.first[0] + x, extent.first[1] + y, extent.first[2] + z}, {row, 1, 1}};
    if (x > 0 || count < row)
      box.points[0] = std::min(row - x, count);
    else if (y > 0 || count < slice)
      box.points[1] = std::min(extent.points[1] - y, count / row);
    else
      box.points = {row, extent.points[1], count / slice};
    use(box, first);
    first += box.count();
    count -= box.count();
  }
}

/// Copies the points that both extents contain from samples laid out as `from` to samples laid out as `to`.
void copyExtent(std::span<const std::byte> source, const Extent& from, std::span<std::byte> target,
                const Extent& to, size_t bytesPerPoint);

}  // namespace gxy
