// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "core/comm/error.h"
#include "core/io/image_header.h"

namespace gxy {
namespace {

constexpr size_t kNiftiHeader = 348;

/// The fields of the header, by position.
class NiftiFields {
 public:
  explicit NiftiFields(std::string_view bytes, bool swap) : bytes_(bytes), swap_(swap) {}
  template <class T>
  T at(size_t place) const {
    std::byte bytes[sizeof(T)];
    std::memcpy(bytes, bytes_.data() + place, sizeof(T));
    if (swap_) swapBytes(bytes, sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

 private:
  std::string_view bytes_;
  bool swap_;
};

void setType(ImageHeader& header, int code, const std::string& where) {
  constexpr struct {
    int code;
    ScalarType type;
    int components;
  } kCodes[] = {{2, ScalarType::UInt8, 1},    {4, ScalarType::Int16, 1},     {8, ScalarType::Int32, 1},
                {16, ScalarType::Float32, 1}, {64, ScalarType::Float64, 1},  {128, ScalarType::UInt8, 3},
                {256, ScalarType::Int8, 1},   {512, ScalarType::UInt16, 1},  {768, ScalarType::UInt32, 1},
                {1024, ScalarType::Int64, 1}, {1280, ScalarType::UInt64, 1}, {2304, ScalarType::UInt8, 4}};
  for (const auto& c : kCodes)
    if (c.code == code) {
      header.type = c.type;
      header.components = c.components;
      return;
    }
  throw Error(where + ": datatype " + std::to_string(code) +
              ", expected integers, floating-point numbers, RGB or RGBA");
}

/// Sets directions and spacings from the columns of a matrix.
void setAxes(ImageData& image, const glm::dmat3& columns) {
  for (int a = 0; a < 3; ++a) {
    const double length = glm::length(columns[a]);
    if (!(length > 0) || !std::isfinite(length)) throw Error(image.path + ": an axis has no direction");
    image.spacing[a] = length;
    for (int w = 0; w < 3; ++w) image.direction[size_t(3 * w + a)] = columns[a][w] / length;
  }
}

/// Method 2 of the format: a quaternion and the sizes of voxels, of which the last may be negated.
glm::dmat3 matrixOfQuaternion(const NiftiFields& f, const glm::dvec3& size) {
  const double b = double(f.at<float>(256)), c = double(f.at<float>(260)), d = double(f.at<float>(264));
  const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + d * d)));
  const double handed = f.at<float>(76) < 0 ? -1 : 1;
  return {
      size.x * glm::dvec3(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)),
      size.y * glm::dvec3(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)),
      handed * size.z * glm::dvec3(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b)};
}

void placeImage(ImageData& image, const NiftiFields& f) {
  constexpr size_t kQform = 252, kSform = 254, kOffset = 268, kRows = 280, kSizes = 80;
  glm::dvec3 size;
  for (int a = 0; a < 3; ++a) size[a] = double(std::abs(f.at<float>(kSizes + 4 * size_t(a))));
  if (f.at<int16_t>(kSform) > 0) {
    glm::dmat3 columns;
    for (int w = 0; w < 3; ++w) {
      for (int a = 0; a < 3; ++a) columns[a][w] = double(f.at<float>(kRows + 16 * size_t(w) + 4 * size_t(a)));
      image.origin[w] = double(f.at<float>(kRows + 16 * size_t(w) + 12));
    }
    return setAxes(image, columns);
  }
  image.spacing = size;
  if (f.at<int16_t>(kQform) <= 0) return;
  for (int w = 0; w < 3; ++w) image.origin[w] = double(f.at<float>(kOffset + 4 * size_t(w)));
  setAxes(image, matrixOfQuaternion(f, size));
}

}  // namespace

ImageHeader parseNifti(std::string_view bytes, const std::string& where) {
  if (bytes.size() < kNiftiHeader)
    throw Error(where + ": the file ends within its header, expected " + std::to_string(kNiftiHeader) +
                " bytes");
  const bool swap = NiftiFields(bytes, false).at<int32_t>(0) != int32_t(kNiftiHeader);
  const NiftiFields f(bytes, swap);
  if (f.at<int32_t>(0) != int32_t(kNiftiHeader) || bytes.substr(344, 4) != std::string_view("n+1\0", 4))
    throw Error(where + ": expected a NIfTI-1 file with header and samples in one (\"n+1\")");
  ImageHeader header;
  header.image.path = where;
  header.swapBytes = swap;
  const int axes = f.at<int16_t>(40);
  if (axes < 1 || axes > 7) throw Error(where + ": " + std::to_string(axes) + " axes, expected 1 to 7");
  for (int a = 0; a < axes; ++a) {
    const int n = f.at<int16_t>(42 + 2 * size_t(a));
    if (n < 1) throw Error(where + ": an axis of " + std::to_string(n) + " points, expected 1 or more");
    if (a < 3)
      header.image.points[size_t(a)] = n;
    else if (n > 1)
      header.image.warnings = {where + ": it holds several images, of which the first is read"};
  }
  setType(header, f.at<int16_t>(70), where);
  const double offset = double(f.at<float>(108));
  if (!(offset >= double(kNiftiHeader) && offset < 0x1p53))
    throw Error(where + ": the samples begin within the header");
  header.offset = int64_t(offset);
  const double slope = double(f.at<float>(112)), intercept = double(f.at<float>(116));
  if (slope != 0 && std::isfinite(slope) && std::isfinite(intercept) && f.at<int16_t>(70) != 128 &&
      f.at<int16_t>(70) != 2304) {
    header.slope = slope;
    header.intercept = intercept;
  }
  placeImage(header.image, f);
  return header;
}

}  // namespace gxy
