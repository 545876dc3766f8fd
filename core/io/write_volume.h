// SPDX-License-Identifier: Apache-2.0
// Volumes to files, by slabs, so that a volume need never be in memory as a whole.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/file.h"
#include "core/io/volume_file.h"

namespace gxy {

/// Writes .vti (appended raw, any number of arrays), .vol + .raw and .json + .raw (one array) by extension,
/// in this machine's byte order. Every sample must be written once; write() may be called from any thread, in
/// any order.
class VolumeWriter {
 public:
  /// Of a grid with a rim the samples of the cells are written, to a .vti only: extents and slices count cells then, and begin
  /// inside the rim. Ranges of arrays, where present, are stated in a .vti. `first` is the index of the grid's first point in
  /// a .vti (a piece of a larger image keeps its place). The first array becomes the active scalars.
  VolumeWriter(const std::string& path, const Grid& grid, std::vector<ArrayInfo> arrays,
               Index3 first = {0, 0, 0});

  /// Samples of slices [slice, slice + n) of array `index`, x fastest, components interleaved.
  void write(size_t index, int64_t slice, std::span<const std::byte> samples) const;
  /// Of a box of points of the grid.
  void write(size_t index, const Extent& box, std::span<const std::byte> samples) const;

 private:
  Grid grid_;
  std::vector<ArrayInfo> arrays_;
  std::unique_ptr<File> file_;
  std::vector<int64_t> places_;  ///< of the first sample of each array
};

/// The file beside a .vol or .json into which a VolumeWriter puts the samples; empty for other extensions.
std::string rawFileOf(const std::string& path);

/// A piece of a .pvti, written by VolumeWriter; its name is relative to the .pvti.
struct ImagePiece {
  Extent extent;
  std::string file;
};
void writePvti(const std::string& path, const Grid& grid, const std::vector<ArrayInfo>& arrays,
               const std::vector<ImagePiece>& pieces);

}  // namespace gxy
