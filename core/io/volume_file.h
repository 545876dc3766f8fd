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

#include "core/data/extents.h"
#include "core/data/volume.h"

namespace gxy {

/// A part of the samples that a read gives: those of `points`. `samples` is laid out as `layout` (x fastest,
/// components interleaved, this machine's byte order). If there are no points, reading has gone on for a
/// while without giving any.
struct SamplesRead {
  size_t wanted;  ///< index of the wanted box that they belong to
  Extent points, layout;
  std::span<const std::byte> samples;
};
/// Takes samples. An exception from it ends the reading.
using TakeSamples = std::function<void(const SamplesRead&)>;

/// The source of the samples of one array. Any thread may read.
class SampleSource {
 public:
  static constexpr int64_t kReadBytes = 8 << 20;  ///< bytes of samples that a read holds at a time

  virtual ~SampleSource() = default;
  /// Passes each point of each box in `wanted` to `take` once, in any order, some megabytes at a time. All
  /// boxes must be inside the grid. Compressed data are decompressed once for all boxes, and `take` is called
  /// about once for each megabyte of them.
  virtual void read(std::span<const Extent> wanted, const TakeSamples& take) const = 0;
  /// The number of pieces (parts of a file, or files) that no read has needed so far.
  virtual uint64_t piecesNotRead() const { return 0; }
};

/// The amount that reading has decoded so far (text, base64, compressed bytes). Blocks are those of the
/// file's compression; each decoding of a block counts, even of a part of it.
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

/// An opened volume: its grid, all its arrays, and the chosen array. It is cheap to copy.
struct VolumeFile {
  std::string path;
  Grid grid;
  std::vector<ArrayInfo> arrays;
  ArrayInfo array;                    ///< the chosen array
  std::vector<std::string> warnings;  ///< about content that is not used, for the user
  std::shared_ptr<const SampleSource> source;
  int64_t heldPerPoint = 0;  ///< bytes that a read holds for each point that it reads, besides the samples
  std::shared_ptr<Decoded> decoded = std::make_shared<Decoded>();  ///< amount decoded by all copies of this

  size_t bytesPerPoint() const { return bytesOf(array.type) * size_t(array.components); }
};

/// Facts that a file does not contain, or that replace those that it contains.
struct RawOptions {
  std::optional<Index3> dimensions;  ///< with `type`: the file has samples only, x fastest
  std::optional<ScalarType> type;
  int components = 1;
  bool bigEndian = false;
  int64_t skip = 0;                           ///< number of bytes before the samples
  std::optional<glm::dvec3> spacing, origin;  ///< allowed for files with a header too
};

/// Whether the extension is listed above; a .vtk file is opened to see what it contains.
bool isVolumeFile(const std::string& path);

/// Opens a volume. `array` is the name of an array; empty means the active scalars, or else the first array.
/// Throws Error for a file that is missing, malformed, truncated or too long, or has no such array.
VolumeFile openVolume(const std::string& path, const std::string& array = {});
/// The same with options. Throws Error also if the options do not fit the file.
VolumeFile openVolume(const std::string& path, const std::string& array, const RawOptions& options);

/// Returns the extensions that openVolume() and readGeometry() know, for messages.
std::string readableFormats();

/// Returns the file as if its array had only these components, which ascend. Throws Error for a component
/// that does not exist.
VolumeFile withComponents(VolumeFile file, std::vector<int> components);

/// A box of points, and memory for its samples: extent.count() * bytesPerPoint() bytes, x fastest,
/// components interleaved.
struct ReadTarget {
  Extent extent;
  std::span<std::byte> out;
};

/// Reads several boxes in one pass. `advance` is called with the number of points read since its last call,
/// which may be 0. An exception from it ends the reading.
void readVolume(const VolumeFile& file, std::span<const ReadTarget> targets,
                const std::function<void(int64_t points)>& advance);
/// Reads one box.
void readVolume(const VolumeFile& file, const Extent& extent, std::span<std::byte> out);

/// The extent of a whole grid.
inline Extent wholeOf(const Grid& grid) { return {{0, 0, 0}, grid.points}; }

}  // namespace gxy
