// SPDX-License-Identifier: Apache-2.0
#include "core/io/lattice_samples.h"

#include <algorithm>
#include <cstring>

#include "core/io/volume_formats.h"

namespace gxy {

int64_t LatticeSamples::Axis::operator()(int64_t i) const {
  const int64_t sample = std::clamp<int64_t>(i - before, 0, points - 1);
  return backwards ? points - 1 - sample : sample;
}

bool LatticeSamples::isIdentity(const Axes& axes, const Index3& points) {
  for (size_t w = 0; w < 3; ++w)
    if (axes[w].source != w || axes[w].backwards || axes[w].before != 0 || axes[w].points != points[w])
      return false;
  return true;
}

void LatticeSamples::read(std::span<const Extent> wanted, const TakeSamples& take) const {
  std::vector<Extent> needed;
  for (const Extent& w : wanted) {
    Extent box;
    for (size_t a = 0; a < 3; ++a) {
      const auto [least, most] = std::minmax({axes_[a](w.first[a]), axes_[a](w.first[a] + w.points[a] - 1)});
      box.first[axes_[a].source] = least;
      box.points[axes_[a].source] = w.points[a] > 0 ? most - least + 1 : 0;
    }
    needed.push_back(box);
  }
  std::vector<std::byte> turned;
  source_->read(needed, [&](const SamplesRead& some) {
    // The points of the wanted box whose samples have come. On each axis they are consecutive.
    Extent box;
    std::array<std::vector<size_t>, 3> place;
    for (size_t a = 0; a < 3 && some.points.count() > 0; ++a) {
      const Extent& w = wanted[some.wanted];
      const size_t s = axes_[a].source;
      size_t stride = bytesPerPoint_;
      for (size_t below = 0; below < s; ++below) stride *= size_t(some.layout.points[below]);
      for (int64_t i = w.first[a]; i < w.first[a] + w.points[a]; ++i) {
        const int64_t sample = axes_[a](i);
        if (sample < some.points.first[s] || sample >= some.points.first[s] + some.points.points[s]) continue;
        if (place[a].empty()) box.first[a] = i;
        place[a].push_back(size_t(sample - some.layout.first[s]) * stride);
      }
      box.points[a] = int64_t(place[a].size());
    }
    turned.resize(size_t(box.count()) * bytesPerPoint_);
    std::byte* to = turned.data();
    for (const size_t z : place[2])
      for (const size_t y : place[1])
        for (const size_t x : place[0]) {
          std::memcpy(to, some.samples.data() + z + y + x, bytesPerPoint_);
          to += bytesPerPoint_;
        }
    take({some.wanted, box, box, turned});
  });
}

}  // namespace gxy
