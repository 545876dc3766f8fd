// SPDX-License-Identifier: Apache-2.0
// Volume files, read in two steps: open() reads what is in the file, read() the samples of any box of points.
//
// .vti .pvti   VTK XML image data, any encoding
// .vtk         legacy structured points, binary or text
// .vol .json   raw samples with a description (volume_description.h)
// .mha .mhd .nrrd .nhdr .nii .nii.gz .npy   a header and raw or gzipped samples (image_header.h)
//
// Images with samples of cells, with axes that are turned, or with one layer become volumes as image_volume.h says.
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

#include "core/data/volume.h"

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

/// One array of points or cells, as its file declares it.
struct ArrayInfo {
  std::string name;  ///< empty for raw files
  ScalarType type = ScalarType::Float32;
  int components = 1;
  std::optional<Range> range;  ///< if the file states it; not verified
  bool ofCells = false;
};

/// An opened volume: its grid, all its arrays, and the one that was chosen. Cheap to copy.
struct VolumeFile {
  std::string path;
  Grid grid;
  std::vector<ArrayInfo> arrays;
  ArrayInfo array;                    ///< the chosen one
  std::vector<std::string> warnings;  ///< what of the file is not used, for its user
  std::shared_ptr<const SampleSource> source;
  int64_t heldPerPoint =
      0;  ///< bytes that a read holds for each point that it is to read, beside the samples
  std::shared_ptr<Decoded> decoded = std::make_shared<Decoded>();  ///< by all copies of this

  size_t bytesPerPoint() const { return bytesOf(array.type) * size_t(array.components); }
};

/// What a file does not say of its samples, or is to be taken as instead.
struct RawOptions {
  std::optional<Index3> dimensions;  ///< with `type`, of a file of samples and nothing else, x fastest
  std::optional<ScalarType> type;
  int components = 1;
  bool bigEndian = false;
  int64_t skip = 0;                           ///< bytes before the samples
  std::optional<glm::dvec3> spacing, origin;  ///< these two also of files with a header of their own
};

/// True for the extensions listed above; a .vtk file is opened to see what it holds.
bool isVolumeFile(const std::string& path);

/// Opens a volume. `array` is a name; empty: the active scalars, else the first array. Throws Error for a
/// file that is missing, malformed, truncated or too long, or that has no such array.
VolumeFile openVolume(const std::string& path, const std::string& array = {});
/// The same with what the options say. Throws Error where they do not suit the file.
VolumeFile openVolume(const std::string& path, const std::string& array, const RawOptions& options);

/// The endings that openVolume() and readGeometry() know, for messages.
std::string readableFormats();

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
