// SPDX-License-Identifier: Apache-2.0
// Colours as arrays of VTK's. Used inside core/io only, by files that see VTK.
#pragma once
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkSmartPointer.h>

#include <array>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/io/flaws.h"
#include "core/io/text_scanner.h"

namespace gxy {

/// The array "RGB" of a reader's own: red, green, blue and, of four components, opacity, all of which are NaN at first.
vtkSmartPointer<vtkFloatArray> makeColors(int components, vtkIdType count);

/// Scales what has been read to 0 to 1. `full`: the largest value of a component; 0 where the file does not say: 1, or 255 where
/// one is 2 or more.
void scaleColors(vtkFloatArray* colors, double full = 0);

/// Colours of vertices or faces that a text has here and there.
class FoundColors {
 public:
  /// Of vertex or face i: `numbers`, three or four. False: they are others, and it has none.
  bool set(size_t i, std::span<const float> numbers);

  /// Of `count` points or cells, of which p has the colour of vertex or face of(p); null if none was found.
  template <class Of>
  vtkSmartPointer<vtkFloatArray> array(vtkIdType count, Of of) const {
    if (colors_.empty()) return nullptr;
    const auto made = makeColors(components_, count);
    for (vtkIdType p = 0; p < count; ++p)
      if (const size_t i = of(p); i < colors_.size()) made->SetTypedTuple(p, colors_[i].data());
    scaleColors(made);
    return made;
  }

 private:
  std::vector<std::array<float, 4>> colors_;  ///< up to the last that was found; NaN where there is none
  int components_ = 3;
};

/// The numbers from here on; those behind what is none are left.
std::vector<float> numbersLeft(TextScanner& line);

/// Whether an array holds colours (values_choice.h).
bool isColors(vtkDataArray* array);

/// Reads colours out of an array that holds some: unsigned char and unsigned short by their largest value, other integers by 255,
/// floating-point numbers as they are.
class ColorsOf {
 public:
  /// `flaws` is told of colours outside 0 to 1, which are clamped, of those that are not finite, which are black, and of opacity,
  /// which is not used. All are kept by their owners.
  ColorsOf(vtkDataArray* array, Flaws& flaws);
  /// Of a point or cell; of a negative index, as of what has none: black.
  glm::vec3 operator()(vtkIdType i) const;

 private:
  vtkDataArray* array_;
  Flaws& flaws_;
  double full_;
};

}  // namespace gxy
