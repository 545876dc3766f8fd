// SPDX-License-Identifier: Apache-2.0
// Volume files, read in two steps: open() reads what is in the file, read() the samples of any box of points.
//
// .vti .pvti   VTK XML image data, any encoding; uncompressed appended data are read by block straight from
// the file .vtk         legacy structured points, binary or text (held in memory as a whole while open) .vol
// .json   raw samples with a description (volume_description.h), read by block
//
// All points of a grid are drawn: none is reserved as a ghost. Cell data are not volumes and are not listed.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gxy/data/volume.h"

namespace gxy {

/// Where the samples of one point array come from. Reads are safe from any thread.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  /// Fills `out`, x fastest, components interleaved, in this machine's byte order. `extent` lies inside the
  /// grid and `out` has its exact size.
  virtual void read(const Extent& extent, std::span<std::byte> out) const = 0;
  /// Whether two reads of half an extent cost about what one of all of it does.
  virtual bool readsPartsAlone() const { return false; }
  /// Of samples in several pieces (parts of a file, or files), those that no read has needed.
  virtual uint64_t piecesNotRead() const { return 0; }
};

/// One point array, as its file declares it.
struct ArrayInfo {
  std::string name;  ///< empty for raw files
  ScalarType type = ScalarType::Float32;
  int components = 1;
  std::optional<Range> range;  ///< if the file states it; not verified
};

/// An opened volume: its grid, all its point arrays, and the one that was chosen. Cheap to copy.
struct VolumeFile {
  std::string path;
  Grid grid;
  std::vector<ArrayInfo> arrays;
  ArrayInfo array;                    ///< the chosen one
  std::vector<std::string> warnings;  ///< what of the file is not used, for its user
  std::shared_ptr<const SampleSource> source;

  size_t bytesPerPoint() const { return bytesOf(array.type) * size_t(array.components); }
};

/// True for the extensions listed above; a .vtk file is opened to see what it holds.
bool isVolumeFile(const std::string& path);

/// Opens a volume. `array` is a name; empty: the active scalars, else the first array. Throws Error for a
/// file that is missing, malformed, truncated or too long, or that has no such array.
VolumeFile openVolume(const std::string& path, const std::string& array = {});

/// The file as if its array had these components only, which ascend. Throws Error for one that it has not.
VolumeFile withComponents(VolumeFile file, std::vector<int> components);

/// Reads the samples of `extent` into `out`, whose size must be extent.count() * bytesPerPoint().
void readVolume(const VolumeFile& file, const Extent& extent, std::span<std::byte> out);

/// The extent of a whole grid.
inline Extent wholeOf(const Grid& grid) { return {{0, 0, 0}, grid.points}; }

}  // namespace gxy
