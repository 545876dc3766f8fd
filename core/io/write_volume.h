// SPDX-License-Identifier: Apache-2.0
// Writes volume files by slabs, so that a volume need never be in memory as a whole.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/file.h"
#include "core/io/volume_file.h"

namespace gxy {

/// Writes a .vti (appended raw, any number of arrays), or a .vol or .json with a .raw (one array), by the
/// path's extension, in this machine's byte order. Every sample must be written once. Any thread may call
/// write(), in any order.
class VolumeWriter {
 public:
  /// For a grid with a rim, the samples of cells are written, to a .vti only; extents and slices then count
  /// cells and begin inside the rim. Ranges of arrays, if known, are stated in a .vti. `first` is the index
  /// of the grid's first point in a .vti, so that a piece of a larger image keeps its place. The first
  /// array becomes the active scalars. Throws Error if the files cannot be created or the format cannot
  /// represent the volume.
  VolumeWriter(const std::string& path, const Grid& grid, std::vector<ArrayInfo> arrays,
               Index3 first = {0, 0, 0});

  /// Writes samples of array `index`, x fastest, components interleaved. They are whole slices from `slice`
  /// on; the size of `samples` gives their number.
  void write(size_t index, int64_t slice, std::span<const std::byte> samples) const;
  /// Writes the samples of a box of points of the grid.
  void write(size_t index, const Extent& box, std::span<const std::byte> samples) const;

 private:
  Grid grid_;
  std::vector<ArrayInfo> arrays_;
  std::unique_ptr<File> file_;
  std::vector<int64_t> places_;  ///< file position of the first sample of each array
};

/// Returns the file beside a .vol or .json that a VolumeWriter writes the samples to; empty for other extensions.
std::string rawFileOf(const std::string& path);

/// A piece of a .pvti, written by VolumeWriter. Its name is relative to the .pvti.
struct ImagePiece {
  Extent extent;
  std::string file;
};
void writePvti(const std::string& path, const Grid& grid, const std::vector<ArrayInfo>& arrays,
               const std::vector<ImagePiece>& pieces);

}  // namespace gxy
