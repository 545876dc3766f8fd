// SPDX-License-Identifier: Apache-2.0
// Reads samples that must be decoded: from compressed bytes, base64 or text. Used inside core/io only.
#pragma once
#include "core/io/byte_stream.h"
#include "core/io/volume_file.h"

namespace gxy {

/// One array, x fastest, components interleaved, in blocks of bytes. A read decodes each block that its boxes
/// need once, up to the last point that they need. Small blocks are decoded on all cores, several at a time. It uses 4 MiB of memory,
/// whatever the size of blocks.
class StreamedSamples final : public SampleSource {
 public:
  /// `bytes` are the samples of the points of `stored` and nothing else. Errors begin with `where`. `decoded`
  /// counts the bytes and blocks that are decoded.
  StreamedSamples(std::shared_ptr<const BlockedBytes> bytes, const Extent& stored, ScalarType type,
                  int components, bool swapBytes, std::string where, std::shared_ptr<Decoded> decoded);
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override;

 private:
  struct Reading;
  bool isWanted(std::span<const Extent> wanted, int64_t block) const;
  void give(std::span<const Extent> wanted, int64_t first, std::span<std::byte> samples,
            const TakeSamples& take) const;
  void readBlocks(Reading& reading, int64_t block, int64_t endBlock) const;

  std::shared_ptr<const BlockedBytes> bytes_;
  Extent stored_;
  int64_t bytesPerPoint_;
  size_t bytesPerSample_;
  bool swapBytes_;
  std::string where_;
  std::shared_ptr<Decoded> decoded_;
};

}  // namespace gxy
