// SPDX-License-Identifier: Apache-2.0
// Volume files, read in two steps: open() reads what is in the file, read() the samples of any box of points.
//
// .vti .pvti   VTK XML image data, any encoding
// .vtk         legacy structured points, binary or text (held in memory as a whole while open)
// .vol .json   raw samples with a description (volume_description.h)
//
// All points of a grid are drawn: none is reserved as a ghost. Cell data are not volumes and are not listed.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gxy/data/volume.h"

namespace gxy {

/// Some of the samples that are read: those of `points`, out of `samples`, which are laid out as `layout` (x fastest, components
/// interleaved, this machine's byte order). No points: reading has gone on for a while without any.
struct SamplesRead {
  size_t wanted;  ///< which of the boxes that were asked for they are of
  Extent points, layout;
  std::span<const std::byte> samples;
};
/// What it throws ends the reading.
using TakeSamples = std::function<void(const SamplesRead&)>;

/// Where the samples of one array come from. Reads are safe from any thread.
class SampleSource {
 public:
  static constexpr int64_t kReadBytes = 8 << 20;  ///< of samples that are held at once

  virtual ~SampleSource() = default;
  /// Gives each point of each box of `wanted`, all inside the grid, to `take` once, in any order, some megabytes at a time. What
  /// is compressed is decompressed once for all boxes, and `take` is called about once for each megabyte of it.
  virtual void read(std::span<const Extent> wanted, const TakeSamples& take) const = 0;
  /// Of samples in several pieces (parts of a file, or files), those that no read has needed.
  virtual uint64_t piecesNotRead() const { return 0; }
};

/// What reading has decoded (text, base64, compressed bytes) so far. Blocks are those that the file is compressed in; each
/// decoding of one counts, also of a part of it.
struct Decoded {
  std::atomic<uint64_t> blocks = 0, bytes = 0;
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
  std::shared_ptr<Decoded> decoded = std::make_shared<Decoded>();  ///< by all copies of this

  size_t bytesPerPoint() const { return bytesOf(array.type) * size_t(array.components); }
};

/// True for the extensions listed above; a .vtk file is opened to see what it holds.
bool isVolumeFile(const std::string& path);

/// Opens a volume. `array` is a name; empty: the active scalars, else the first array. Throws Error for a
/// file that is missing, malformed, truncated or too long, or that has no such array.
VolumeFile openVolume(const std::string& path, const std::string& array = {});

/// The file as if its array had these components only, which ascend. Throws Error for one that it has not.
VolumeFile withComponents(VolumeFile file, std::vector<int> components);

/// A box of points, and where its samples go: extent.count() * bytesPerPoint() bytes, x fastest, components interleaved.
struct ReadTarget {
  Extent extent;
  std::span<std::byte> out;
};

/// Reads several boxes in one pass. `advance` is called with the number of points that have come since it was called last, perhaps
/// none; what it throws ends the reading.
void readVolume(const VolumeFile& file, std::span<const ReadTarget> targets,
                const std::function<void(int64_t points)>& advance);
/// Reads one box.
void readVolume(const VolumeFile& file, const Extent& extent, std::span<std::byte> out);

/// Copies the points of `box`, which both extents hold, from samples laid out as `from` to samples laid out as `to`.
void copyBox(const Extent& box, std::span<const std::byte> source, const Extent& from,
             std::span<std::byte> target, const Extent& to, size_t bytesPerPoint);

/// The extent of a whole grid.
inline Extent wholeOf(const Grid& grid) { return {{0, 0, 0}, grid.points}; }

}  // namespace gxy
