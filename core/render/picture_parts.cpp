// SPDX-License-Identifier: Apache-2.0
#include "core/render/picture_parts.h"

#include <algorithm>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

int quotientRoundedUp(int a, int b) { return (a + b - 1) / b; }

// Reads the values of a part, so many for each pixel, into its rows of the whole.
template <class Vector>
void readRows(Reader& in, const PictureParts& parts, int part, size_t perPixel, Vector& whole) {
  using Value = typename Vector::value_type;
  const std::vector<Value> values = in.readVector<Value>();
  const size_t width = whole.empty() ? 0 : size_t(parts.size().x) * perPixel;
  const Rows rows = parts.rows(part);
  if (values.size() != width * size_t(rows.count()))
    in.fail("part " + std::to_string(part) + " of a picture has " + std::to_string(values.size()) +
            " values, expected " + std::to_string(width * size_t(rows.count())));
  std::ranges::copy(values, whole.begin() + ptrdiff_t(width * size_t(rows.first)));
}

}  // namespace

PictureParts::PictureParts(uint64_t frame, glm::ivec2 size, int ranks, int ranksPerPart)
    : size_(size),
      ranks_(ranks),
      owner_(int(frame % uint64_t(ranks))),
      rowsEach_(quotientRoundedUp(size.y, quotientRoundedUp(ranks, ranksPerPart))),
      count_(quotientRoundedUp(size.y, rowsEach_)),
      stride_(ranks / count_) {}

std::optional<int> PictureParts::ofRank(int rank) const {
  const int after = (rank - owner_ + ranks_) % ranks_;
  if (after % stride_ != 0 || after / stride_ >= count_) return {};
  return after / stride_;
}

Rows PictureParts::rows(int part) const {
  return {part * rowsEach_, std::min((part + 1) * rowsEach_, size_.y)};
}

Bytes bytesOfPart(int part, const Picture& rows) {
  Writer w;
  w.write(int32_t(part)).write(std::string()).write(int32_t(rows.samples));
  w.write(std::span<const float>(rows.rgba)).write(rows.depth).write(std::span<const int64_t>(rows.sums));
  return w.take();
}

Bytes bytesOfPart(int part, const std::string& error) {
  return Writer().write(int32_t(part)).write(error).take();
}

Picture joined(const PictureParts& parts, bool sums, bool depth,
               std::span<const std::span<const std::byte>> messages) {
  const size_t pixels = parts.end(parts.count() - 1);
  Picture whole;
  whole.width = parts.size().x;
  whole.height = parts.size().y;
  if (sums)
    whole.sums.resize(4 * pixels);
  else
    whole.rgba.resize(4 * pixels);
  if (depth) whole.depth.resize(pixels);
  std::vector<bool> came(size_t(parts.count()), false);
  for (const std::span<const std::byte> message : messages)
    for (Reader in(message, "parts of a picture"); !in.rest().empty();) {
      const auto part = in.read<int32_t>();
      const std::string error = in.readString();
      if (part < 0 || part >= parts.count() || came[size_t(part)])
        in.fail("part " + std::to_string(part) + " of a picture of " + std::to_string(parts.count()) +
                " came, expected each of them once");
      if (!error.empty())
        throw Error("the part of the picture on rank " + std::to_string(parts.rank(part)) + ": " + error);
      came[size_t(part)] = true;
      whole.samples = in.read<int32_t>();
      readRows(in, parts, part, 4, whole.rgba);
      readRows(in, parts, part, 1, whole.depth);
      readRows(in, parts, part, 4, whole.sums);
    }
  if (const auto missing = std::ranges::find(came, false); missing != came.end())
    throw Error("part " + std::to_string(missing - came.begin()) + " of a picture of " +
                std::to_string(parts.count()) + " has not come");
  return whole;
}

}  // namespace gxy
