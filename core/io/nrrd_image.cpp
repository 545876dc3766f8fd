// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <optional>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/header_lines.h"
#include "core/io/image_header.h"
#include "core/io/number_text.h"

namespace gxy {
namespace {

ScalarType typeOfNrrdWords(std::string_view value, const HeaderLines& lines) {
  static const std::map<std::string, ScalarType> kWords{{"signed char", ScalarType::Int8},
                                                        {"int8", ScalarType::Int8},
                                                        {"int8_t", ScalarType::Int8},
                                                        {"uchar", ScalarType::UInt8},
                                                        {"unsigned char", ScalarType::UInt8},
                                                        {"uint8", ScalarType::UInt8},
                                                        {"uint8_t", ScalarType::UInt8},
                                                        {"short", ScalarType::Int16},
                                                        {"short int", ScalarType::Int16},
                                                        {"signed short", ScalarType::Int16},
                                                        {"signed short int", ScalarType::Int16},
                                                        {"int16", ScalarType::Int16},
                                                        {"int16_t", ScalarType::Int16},
                                                        {"ushort", ScalarType::UInt16},
                                                        {"unsigned short", ScalarType::UInt16},
                                                        {"unsigned short int", ScalarType::UInt16},
                                                        {"uint16", ScalarType::UInt16},
                                                        {"uint16_t", ScalarType::UInt16},
                                                        {"int", ScalarType::Int32},
                                                        {"signed int", ScalarType::Int32},
                                                        {"int32", ScalarType::Int32},
                                                        {"int32_t", ScalarType::Int32},
                                                        {"uint", ScalarType::UInt32},
                                                        {"unsigned int", ScalarType::UInt32},
                                                        {"uint32", ScalarType::UInt32},
                                                        {"uint32_t", ScalarType::UInt32},
                                                        {"longlong", ScalarType::Int64},
                                                        {"long long", ScalarType::Int64},
                                                        {"long long int", ScalarType::Int64},
                                                        {"signed long long", ScalarType::Int64},
                                                        {"signed long long int", ScalarType::Int64},
                                                        {"int64", ScalarType::Int64},
                                                        {"int64_t", ScalarType::Int64},
                                                        {"ulonglong", ScalarType::UInt64},
                                                        {"unsigned long long", ScalarType::UInt64},
                                                        {"unsigned long long int", ScalarType::UInt64},
                                                        {"uint64", ScalarType::UInt64},
                                                        {"uint64_t", ScalarType::UInt64},
                                                        {"float", ScalarType::Float32},
                                                        {"double", ScalarType::Float64}};
  const auto found = kWords.find(lowerCase(value));
  if (found == kWords.end())
    lines.fail("unknown type " + inQuotes(value.substr(0, 40)) + ", expected uchar, float and the like");
  return found->second;
}

/// Parses vectors in parentheses; "none" means no vector.
std::vector<std::optional<glm::dvec3>> vectorsOf(std::string_view value, const HeaderLines& lines) {
  std::vector<std::optional<glm::dvec3>> vectors;
  for (value = trimmed(value); !value.empty(); value = trimmed(value)) {
    if (value.starts_with("none")) {
      vectors.push_back({});
      value.remove_prefix(4);
      continue;
    }
    const size_t end = value.find(')');
    if (value.front() != '(' || end == value.npos) lines.fail("expected vectors such as (1,0,0), or none");
    std::string numbers(value.substr(1, end - 1));
    for (char& c : numbers)
      if (c == ',') c = ' ';
    const size_t count = wordsOf(numbers).size() == 2 ? 2 : 3;
    const auto v = lines.numbers(numbers, count);
    vectors.push_back(glm::dvec3(v[0], v[1], count == 3 ? v[2] : 0));
    value.remove_prefix(end + 1);
  }
  return vectors;
}

class Nrrd {
 public:
  Nrrd(std::string_view bytes, const std::string& where) : lines_(bytes, where) {
    header_.image.path = where;
    std::string_view line;
    if (!lines_.next(line) || !line.starts_with("NRRD000"))
      lines_.fail("expected \"NRRD000\" and a version first");
    while (lines_.next(line)) {
      if (line.empty()) break;
      const size_t colon = line.find(": ");
      if (line.starts_with('#') || line.find(":=") < colon) continue;
      if (colon == line.npos)
        lines_.fail("found " + inQuotes(line.substr(0, 40)) + ", expected a field, ':' and a value");
      set(lowerCase(line.substr(0, colon)), trimmed(line.substr(colon + 2)));
    }
    finish();
  }
  ImageHeader take() { return std::move(header_); }

 private:
  void set(const std::string& field, std::string_view value) {
    if (field == "type") {
      header_.type = typeOfNrrdWords(value, lines_);
      typed_ = true;
    } else if (field == "dimension") {
      dimension_ = size_t(lines_.integer(value, 1, 16));
    } else if (field == "sizes") {
      for (const double n : lines_.numbers(value, dimension_)) {
        if (!(n >= 1 && n < 0x1p53)) lines_.fail("expected sizes of 1 or more");
        sizes_.push_back(int64_t(n));
      }
    } else if (field == "spacings") {
      spacings_ = lines_.numbers(value, dimension_);
    } else if (field == "axis mins" || field == "axismins") {
      mins_ = lines_.numbers(value, dimension_);
    } else if (field == "space directions") {
      directions_ = vectorsOf(value, lines_);
    } else if (field == "space origin") {
      const auto origin = vectorsOf(value, lines_);
      if (origin.size() != 1 || !origin[0]) lines_.fail("expected one vector");
      header_.image.origin = *origin[0];
      placed_ = true;
    } else if (field == "kinds") {
      for (const std::string_view kind : wordsOf(value)) kinds_.push_back(lowerCase(kind));
    } else if (field == "encoding") {
      const std::string encoding = lowerCase(value);
      header_.text = encoding == "txt" || encoding == "text" || encoding == "ascii";
      if (encoding == "gz" || encoding == "gzip")
        header_.compression = Compression::Zlib;
      else if (encoding != "raw" && !header_.text)
        lines_.fail("encoding " + inQuotes(encoding.substr(0, 40)) + ", expected raw, gzip or ascii");
    } else if (field == "endian") {
      header_.swapBytes = (lowerCase(value) == "big") != (std::endian::native == std::endian::big);
    } else if (field == "data file" || field == "datafile") {
      if (value == "LIST" || value.starts_with("LIST ") || value.find('%') != value.npos)
        lines_.fail("the samples are in several files; read are images in one file");
      header_.dataFile = std::string(value);
    } else if (field == "byte skip" || field == "byteskip") {
      header_.offset = lines_.integer(value, -1, int64_t(1) << 53);
    } else if ((field == "line skip" || field == "lineskip") && lines_.integer(value, 0, 1 << 30) > 0) {
      lines_.fail("lines before the samples are not passed over; expected line skip: 0");
    }
  }

  /// Whether the first axis is that of components.
  bool firstIsOfComponents() const {
    if (!directions_.empty() && !directions_[0]) return true;
    static const char* kSpatial[] = {"domain", "space", "time", "???", "none"};
    if (!kinds_.empty() && dimension_ > 1)
      return std::find(std::begin(kSpatial), std::end(kSpatial), kinds_[0]) == std::end(kSpatial);
    return dimension_ == 4;
  }

  void finish() {
    if (!typed_ || sizes_.empty()) lines_.fail("expected the fields type, dimension and sizes");
    const size_t skipped = firstIsOfComponents() ? 1 : 0;
    if (skipped) {
      if (sizes_[0] > 1024) lines_.fail("expected at most 1024 components");
      header_.components = int(sizes_[0]);
    }
    const size_t axes = dimension_ - skipped;
    if (axes < 1 || axes > 3)
      lines_.fail("there are " + std::to_string(axes) + " axes of space, expected 1 to 3");
    if (!directions_.empty() && directions_.size() != dimension_)
      lines_.fail("expected as many space directions as axes");
    ImageData& image = header_.image;
    for (size_t a = 0; a < axes; ++a) {
      const size_t axis = a + skipped;
      image.points[a] = sizes_[axis];
      if (!spacings_.empty() && std::isfinite(spacings_[axis])) image.spacing[int(a)] = spacings_[axis];
      if (!placed_ && !mins_.empty() && std::isfinite(mins_[axis])) image.origin[int(a)] = mins_[axis];
      if (directions_.empty()) continue;
      if (!directions_[axis]) lines_.fail("an axis of space has no direction");
      const double length = glm::length(*directions_[axis]);
      if (!(length > 0) || !std::isfinite(length))
        lines_.fail("an axis of space has a direction without length");
      image.spacing[int(a)] = length;
      for (size_t w = 0; w < 3; ++w) image.direction[3 * w + a] = (*directions_[axis])[int(w)] / length;
    }
    const int64_t here = header_.dataFile.empty() ? int64_t(lines_.position()) : 0;
    if (header_.offset != ImageHeader::kAtEnd && header_.compression == Compression::None)
      header_.offset += here;
    if (header_.compression != Compression::None) {
      if (header_.offset != 0)
        lines_.fail("bytes before compressed samples are not passed over; expected byte skip: 0");
      header_.offset = here;
    }
  }

  HeaderLines lines_;
  ImageHeader header_;
  size_t dimension_ = 0;
  std::vector<int64_t> sizes_;
  std::vector<double> spacings_, mins_;
  std::vector<std::optional<glm::dvec3>> directions_;
  std::vector<std::string> kinds_;
  bool typed_ = false, placed_ = false;
};

}  // namespace

ImageHeader parseNrrd(std::string_view bytes, const std::string& where) { return Nrrd(bytes, where).take(); }

}  // namespace gxy
