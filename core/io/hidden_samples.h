// SPDX-License-Identifier: Apache-2.0
// Samples that VTK's ghost arrays hide become NaN, which means "no data". Used inside core/io only.
#pragma once
#include "core/io/volume_file.h"

namespace gxy {

/// Reads another source and replaces hidden samples by NaN. It holds one byte for each point that is read.
class HiddenSamples final : public SampleSource {
 public:
  struct Ghosts {
    std::shared_ptr<const SampleSource> ofPoints, ofCells;  ///< one byte per point or cell; null: none
    Index3 points, cells;                                   ///< numbers of points and cells of the image
    bool samplesOfCells;                                    ///< the samples belong to cells, not to points
  };
  /// Returns the type of the samples with NaN, where the source's samples are of `type`.
  static ScalarType typeFor(ScalarType type);

  HiddenSamples(std::shared_ptr<const SampleSource> source, ScalarType type, int components, Ghosts ghosts)
      : source_(std::move(source)), type_(type), components_(components), ghosts_(std::move(ghosts)) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override;
  uint64_t piecesNotRead() const override { return source_->piecesNotRead(); }

 private:
  using Flags = std::vector<std::byte>;  ///< 1: hidden
  std::vector<Flags> hiddenOf(std::span<const Extent> wanted, const TakeSamples& take) const;

  std::shared_ptr<const SampleSource> source_;
  ScalarType type_;
  int components_;
  Ghosts ghosts_;
};

}  // namespace gxy
