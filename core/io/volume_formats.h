// SPDX-License-Identifier: Apache-2.0
// The readers behind openVolume(), one per format. Used inside core/io only.
#pragma once
#include "gxy/io/volume_file.h"

namespace gxy {

VolumeFile openRawVolume(const std::string& path);                               ///< .vol .json
VolumeFile openVti(const std::string& path, const std::string& array);           ///< .vti
VolumeFile openPvti(const std::string& path, const std::string& array);          ///< .pvti
VolumeFile openLegacyVolume(const std::string& path, const std::string& array);  ///< .vtk

/// The array called `name`, or `active`, or the first; Error listing what there is.
const ArrayInfo& chooseArray(const std::vector<ArrayInfo>& arrays, const std::string& name,
                             const std::string& active, const std::string& path);

/// The points that two extents share; count 0 when there are none.
Extent intersection(const Extent& a, const Extent& b);

/// Copies the points that both extents hold from samples laid out as `from` to samples laid out as `to`.
void copyExtent(std::span<const std::byte> source, const Extent& from, std::span<std::byte> target,
                const Extent& to, size_t bytesPerPoint);

}  // namespace gxy
