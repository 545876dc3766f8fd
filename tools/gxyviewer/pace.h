// SPDX-License-Identifier: Apache-2.0
// How much of a picture is asked for while the camera moves, so that frames keep up with it.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

namespace gxy {

/// One pixel stands for scale x scale of the window's, as JPEG of this quality.
struct Detail {
  uint32_t scale = 4;
  int quality = 70;
  bool operator==(const Detail&) const = default;
};

/// Chooses the finest detail whose rendering and whose transfer both fit into a frame's time, from what frames before have
/// cost. Going finer needs some room, so that it does not go to and fro; what a scale cost is forgotten slowly while another
/// is used, so that it is tried again. Pure arithmetic: no clock.
class Pace {
 public:
  /// What a frame's first pass took: seconds of the server; bytes, and the seconds from the first of them to the last,
  /// where there were enough of them to say how fast the link is.
  struct Pass {
    Detail detail;
    double rendering = 0;
    uint64_t bytes = 0;
    std::optional<double> bytesPerSecond;
  };
  void take(const Pass& pass);

  /// For the next frame.
  Detail choose();
  /// The window has so many times as many pixels now.
  void resized(double factor);

  static constexpr double kFrame = 0.06;  ///< seconds that rendering, and beside it the transfer, may take
  static constexpr std::array<uint32_t, 8> kScales{1, 2, 3, 4, 6, 8, 12, 16};

 private:
  struct Cost {
    double seconds = 0, bytes = 0;  ///< of a frame; bytes at quality 70
  };
  static size_t indexOf(uint32_t scale);
  Cost expected(size_t index) const;
  bool fits(Detail detail) const;

  Detail last_;
  std::array<std::optional<Cost>, kScales.size()> costs_;  ///< smoothed; none before the first of its scale
  std::optional<double> secondsPerByte_;
};

}  // namespace gxy
