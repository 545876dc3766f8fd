// SPDX-License-Identifier: Apache-2.0
// Reads uncompressed samples of any box of points directly from their place in a file.
#pragma once
#include "core/io/file.h"
#include "core/io/volume_file.h"

namespace gxy {

/// One array of samples in a file, laid out as `stored` (x fastest) from byte `offset` on. The constructor
/// throws Error if the file is shorter than that, or, with `exact`, longer.
class RawSamples final : public SampleSource {
 public:
  RawSamples(std::shared_ptr<const File> file, int64_t offset, const Extent& stored, ScalarType type,
             int components, bool swapBytes, bool exact);
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override;

 private:
  void readBox(const Extent& extent, std::span<std::byte> out) const;
  void readSlab(const Extent& slab, std::span<std::byte> out) const;

  std::shared_ptr<const File> file_;
  int64_t offset_;
  Extent stored_;
  size_t bytesPerSample_, bytesPerPoint_;
  bool swapBytes_;
};

}  // namespace gxy
