// SPDX-License-Identifier: Apache-2.0
#include "core/io/raw_samples.h"

#include <algorithm>
#include <cstring>

#include "core/comm/error.h"
#include "core/data/extent_pieces.h"
#include "core/io/volume_description.h"
#include "core/io/volume_formats.h"

namespace gxy {
namespace {

constexpr int64_t kRunBytes = 4 << 20;  ///< rows within this many bytes are read together
constexpr int64_t kWaste = 4;           ///< ... unless more than 3/4 of the bytes read would be discarded

}  // namespace

RawSamples::RawSamples(std::shared_ptr<const File> file, int64_t offset, const Extent& stored,
                       ScalarType type, int components, bool swapBytes, bool exact)
    : file_(std::move(file)),
      offset_(offset),
      stored_(stored),
      bytesPerSample_(bytesOf(type)),
      bytesPerPoint_(bytesOf(type) * size_t(components)),
      swapBytes_(swapBytes) {
  const int64_t needed = stored.count() * int64_t(bytesPerPoint_), has = file_->size() - offset;
  if (has < needed || (exact && has > needed))
    throw Error(file_->path() + ": " + (has < needed ? "truncated: " : "too long: ") +
                std::to_string(std::max(has, int64_t(0))) + " bytes, expected " + std::to_string(needed) +
                " (" + std::to_string(stored.points[0]) + " x " + std::to_string(stored.points[1]) + " x " +
                std::to_string(stored.points[2]) + " points of " + std::to_string(bytesPerPoint_) +
                " bytes)");
}

void RawSamples::read(std::span<const Extent> wanted, const TakeSamples& take) const {
  std::vector<std::byte> buffer;
  for (size_t w = 0; w < wanted.size(); ++w)
    forPieces(wanted[w], kReadBytes / int64_t(bytesPerPoint_), [&](const Extent& piece) {
      buffer.resize(size_t(piece.count()) * bytesPerPoint_);
      readBox(piece, buffer);
      take({w, piece, piece, buffer});
    });
}

void RawSamples::readBox(const Extent& extent, std::span<std::byte> out) const {
  // Whole slices are consecutive both in the file and in memory, so one read takes all. Otherwise it is one
  // slice at a time.
  const bool wholeSlices = extent.points[0] == stored_.points[0] && extent.points[1] == stored_.points[1];
  const int64_t depth = wholeSlices ? extent.points[2] : 1;
  Extent slab = extent;
  slab.points[2] = depth;
  const size_t bytes = size_t(slab.count()) * bytesPerPoint_;
  for (; slab.first[2] < extent.first[2] + extent.points[2]; slab.first[2] += depth, out = out.subspan(bytes))
    readSlab(slab, out.first(bytes));
}

void RawSamples::readSlab(const Extent& slab, std::span<std::byte> out) const {
  const int64_t point = int64_t(bytesPerPoint_);
  const int64_t stride = stored_.points[0] * point, row = slab.points[0] * point, rows = slab.points[1];
  int64_t place =
      offset_ +
      (((slab.first[2] - stored_.first[2]) * stored_.points[1] + (slab.first[1] - stored_.first[1])) *
           stored_.points[0] +
       (slab.first[0] - stored_.first[0])) *
          point;
  if (row == stride) {
    file_->readAt(place, out);
  } else if (row * kWaste >= stride && stride <= kRunBytes) {
    std::vector<std::byte> run;
    for (int64_t j = 0; j < rows;) {
      const int64_t some = std::min(rows - j, std::max(int64_t(1), kRunBytes / stride));
      run.resize(size_t((some - 1) * stride + row));
      file_->readAt(place + j * stride, run);
      for (int64_t k = 0; k < some; ++k, ++j)
        std::memcpy(out.data() + j * row, run.data() + k * stride, size_t(row));
    }
  } else {
    for (int64_t j = 0; j < rows; ++j)
      file_->readAt(place + j * stride, out.subspan(size_t(j * row), size_t(row)));
  }
  if (swapBytes_) swapBytes(out, bytesPerSample_);
}

VolumeFile openRawVolume(const std::string& path) {
  const std::string text = readText(path);
  const VolumeDescription d =
      extensionOf(path) == ".vol" ? parseVol(text, path) : parseVolumeJson(text, path);
  VolumeFile file;
  file.path = path;
  file.grid = d.grid;
  file.array = {{}, d.type, d.components, {}};
  file.arrays = {file.array};
  file.warnings = d.warnings;
  file.source =
      std::make_shared<RawSamples>(std::make_shared<const File>(File::open(beside(path, d.rawFile))), 0,
                                   wholeOf(d.grid), d.type, d.components, d.swapBytes, true);
  return file;
}

}  // namespace gxy
