// SPDX-License-Identifier: Apache-2.0
// Colours in VTK arrays. Used inside core/io only, by files that include VTK.
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

/// Makes the array "RGB" of one of our readers: red, green, blue and, with four components, opacity. All
/// values are NaN.
vtkSmartPointer<vtkFloatArray> makeColors(int components, vtkIdType count);

/// Scales colours to 0 to 1. `full` is the largest value that a component can have. 0 means that the file
/// does not say: then it is 255 if a component is 2 or more, and else 1.
void scaleColors(vtkFloatArray* colors, double full = 0);

/// Collects colours in a text where only some vertices or faces have one.
class FoundColors {
 public:
  /// Sets the colour of vertex or face i. Returns false, and sets none, unless there are three or four numbers.
  bool set(size_t i, std::span<const float> numbers);

  /// Returns the colours of `count` points or cells, where p has the colour of vertex or face of(p); null
  /// if none was set.
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
  std::vector<std::array<float, 4>> colors_;  ///< up to the last one set; NaN for those without a colour
  int components_ = 3;
};

/// Returns the numbers that follow, up to the first word that is not a number.
std::vector<float> numbersLeft(TextScanner& line);

/// Whether an array contains colours (values_choice.h).
bool isColors(vtkDataArray* array);

/// Reads colours from an array. Unsigned short is scaled by its largest value, other integers by 255, and
/// floating-point numbers are not scaled.
class ColorsOf {
 public:
  /// Both arguments must outlive the object. `flaws` gets colours outside 0 to 1, which are clamped, colours
  /// that are missing or not finite, which are black, and opacity, which is not used.
  ColorsOf(vtkDataArray* array, Flaws& flaws);
  /// Returns the colour of a point or cell; black for a negative index, which means that it has none.
  glm::vec3 operator()(vtkIdType i) const;

 private:
  vtkDataArray* array_;
  Flaws& flaws_;
  double full_;
};

}  // namespace gxy
