// SPDX-License-Identifier: Apache-2.0
// Chooses the resolution and quality of frames while the camera moves, so that frames keep up with it.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

namespace gxy {

/// A frame in JPEG of this quality, where a pixel stands for scale x scale pixels of the window.
struct Detail {
  uint32_t scale = 4;
  int quality = 70;
  bool operator==(const Detail&) const = default;
};

/// Chooses the finest detail whose rendering and whose transfer both fit into the time of a frame, by the
/// cost of earlier frames. A finer detail must fit with some reserve, so that the choice does not oscillate.
/// The known cost of a scale slowly decreases while other scales are used, so that it is tried again. It is
/// pure arithmetic and uses no clock.
class Pace {
 public:
  /// The cost of a frame's first pass.
  struct Pass {
    Detail detail;
    double rendering = 0;                  ///< seconds of rendering on the server
    uint64_t bytes = 0;                    ///< bytes of its pixels
    std::optional<double> bytesPerSecond;  ///< speed of the link; absent: too few bytes to tell
  };
  void take(const Pass& pass);

  /// Returns the detail for the next frame.
  Detail choose();
  /// Called when the window has `factor` times as many pixels as before.
  void resized(double factor);

  static constexpr double kFrame = 0.06;  ///< seconds that rendering may take, and that the transfer may take
  static constexpr std::array<uint32_t, 8> kScales{1, 2, 3, 4, 6, 8, 12, 16};

 private:
  struct Cost {
    double seconds = 0, bytes = 0;  ///< cost of a frame; bytes are those at quality 70
  };
  static size_t indexOf(uint32_t scale);
  Cost expected(size_t index) const;
  bool fits(Detail detail) const;

  Detail last_;
  std::array<std::optional<Cost>, kScales.size()> costs_;  ///< by scale, smoothed; absent if not measured yet
  std::optional<double> secondsPerByte_;
};

}  // namespace gxy
