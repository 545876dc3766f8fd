// SPDX-License-Identifier: Apache-2.0
// Samples whose axes are flipped, exchanged, or continued at their ends. Used inside core/io only.
#pragma once
#include <array>

#include "core/io/volume_file.h"

namespace gxy {

/// Reads another source with other axes. Index i on an axis is sample i - before of the source's axis, or the
/// nearest one that exists.
class LatticeSamples final : public SampleSource {
 public:
  struct Axis {
    size_t source;   ///< the source's axis
    int64_t points;  ///< number of points of the source on that axis
    int64_t before;  ///< number of repeated layers at the beginning
    bool backwards;  ///< the source's last sample comes first
    int64_t operator()(int64_t i) const;
  };
  using Axes = std::array<Axis, 3>;
  static bool isIdentity(const Axes& axes, const Index3& points);

  LatticeSamples(std::shared_ptr<const SampleSource> source, const Axes& axes, size_t bytesPerPoint)
      : source_(std::move(source)), axes_(axes), bytesPerPoint_(bytesPerPoint) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override;
  uint64_t piecesNotRead() const override { return source_->piecesNotRead(); }

 private:
  std::shared_ptr<const SampleSource> source_;
  Axes axes_;
  size_t bytesPerPoint_;
};

}  // namespace gxy
