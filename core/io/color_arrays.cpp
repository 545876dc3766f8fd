// SPDX-License-Identifier: Apache-2.0
#include "core/io/color_arrays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/io/values_choice.h"
#include "core/io/vtk_scalars.h"

namespace gxy {
namespace {

double largestOf(int vtkType) {
  if (vtkType == VTK_FLOAT || vtkType == VTK_DOUBLE) return 1;
  return vtkType == VTK_UNSIGNED_SHORT ? 65535 : 255;
}

}  // namespace

vtkSmartPointer<vtkFloatArray> makeColors(int components, vtkIdType count) {
  const auto colors = vtkSmartPointer<vtkFloatArray>::New();
  colors->SetName("RGB");
  colors->SetNumberOfComponents(components);
  colors->SetNumberOfTuples(count);
  colors->Fill(std::numeric_limits<double>::quiet_NaN());
  return colors;
}

void scaleColors(vtkFloatArray* colors, double full) {
  float* const values = colors->GetPointer(0);
  float* const end = values + colors->GetNumberOfValues();
  if (full == 0)
    full = std::any_of(values, end, [](float v) { return std::isfinite(v) && v >= 2; }) ? 255 : 1;
  for (float* v = values; v != end; ++v) *v = float(*v / full);
}

bool FoundColors::set(size_t i, std::span<const float> numbers) {
  if (numbers.size() != 3 && numbers.size() != 4) return false;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  if (i >= colors_.size()) colors_.resize(i + 1, {kNone, kNone, kNone, kNone});
  std::copy(numbers.begin(), numbers.end(), colors_[i].begin());
  components_ = std::max(components_, int(numbers.size()));
  return true;
}

std::vector<float> numbersLeft(TextScanner& line) {
  std::vector<float> numbers;
  for (double value = 0; TextScanner::parse(line.word(), value);) numbers.push_back(float(value));
  return numbers;
}

bool isColors(vtkDataArray* array) {
  const auto type = scalarOfVtk(array->GetDataType());
  return array->GetName() && type && isColors(array->GetName(), *type, array->GetNumberOfComponents());
}

ColorsOf::ColorsOf(vtkDataArray* array, Flaws& flaws)
    : array_(array), flaws_(flaws), full_(largestOf(array->GetDataType())) {}

glm::vec3 ColorsOf::operator()(vtkIdType i) const {
  const auto place = [&] {
    return "array '" + std::string(array_->GetName()) + "'" + (i < 0 ? "" : ", entry " + std::to_string(i));
  };
  glm::vec3 color(0);
  bool finite = i >= 0, inside = true;
  for (int c = 0; finite && c < 3; ++c) {
    const double value = array_->GetComponent(i, c) / full_;
    finite = std::isfinite(value);
    inside = inside && value >= 0 && value <= 1;
    color[c] = float(std::clamp(value, 0., 1.));
  }
  if (!finite) {
    flaws_.add("a colour that is missing or not finite is black", place);
    return glm::vec3(0);
  }
  if (!inside) flaws_.add("a colour outside 0 to 1 is clamped", place);
  if (array_->GetNumberOfComponents() == 4 && array_->GetComponent(i, 3) / full_ < 1)
    flaws_.add("the opacity of colours is not used: that of the operator is", place);
  return color;
}

}  // namespace gxy
