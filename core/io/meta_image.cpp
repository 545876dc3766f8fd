// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <map>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/header_lines.h"
#include "core/io/image_header.h"

namespace gxy {
namespace {

ScalarType typeOfMetaWord(std::string_view word, const HeaderLines& lines) {
  static const std::map<std::string_view, ScalarType> kWords{
      {"MET_CHAR", ScalarType::Int8},       {"MET_UCHAR", ScalarType::UInt8},
      {"MET_SHORT", ScalarType::Int16},     {"MET_USHORT", ScalarType::UInt16},
      {"MET_INT", ScalarType::Int32},       {"MET_UINT", ScalarType::UInt32},
      {"MET_LONG", ScalarType::Int32},      {"MET_ULONG", ScalarType::UInt32},
      {"MET_LONG_LONG", ScalarType::Int64}, {"MET_ULONG_LONG", ScalarType::UInt64},
      {"MET_FLOAT", ScalarType::Float32},   {"MET_DOUBLE", ScalarType::Float64}};
  const auto found = kWords.find(word);
  if (found == kWords.end())
    lines.fail("unknown ElementType " + inQuotes(word.substr(0, 40)) +
               ", expected MET_UCHAR, MET_FLOAT and the like");
  return found->second;
}

/// Collects the keys that are needed. Keys may come in any order, except that NDims must be first and
/// ElementDataFile last.
class MetaImage {
 public:
  MetaImage(std::string_view bytes, const std::string& where) : lines_(bytes, where) {
    header_.image.path = where;
    std::string_view line;
    while (lines_.next(line)) {
      const size_t equals = line.find('=');
      if (equals == line.npos) {
        if (trimmed(line).empty()) continue;
        lines_.fail("found " + inQuotes(line.substr(0, 40)) + ", expected a key, '=' and a value");
      }
      const std::string key(trimmed(line.substr(0, equals)));
      if (key == "ElementDataFile") {
        finish(std::string(trimmed(line.substr(equals + 1))));
        return;
      }
      set(key, trimmed(line.substr(equals + 1)));
    }
    lines_.fail("the header ends, expected ElementDataFile");
  }
  ImageHeader take() { return std::move(header_); }

 private:
  void set(const std::string& key, std::string_view value) {
    ImageData& image = header_.image;
    const bool yes = lowerCase(value) == "true" || value == "1";
    if (key == "NDims") {
      axes_ = size_t(lines_.integer(value, 2, 3));
    } else if (key == "DimSize") {
      const auto sizes = lines_.numbers(value, axes());
      for (size_t a = 0; a < axes_; ++a) {
        if (!(sizes[a] >= 1 && sizes[a] < 0x1p53)) lines_.fail("expected sizes of 1 or more");
        image.points[a] = int64_t(sizes[a]);
      }
      sized_ = true;
    } else if (key == "ElementSpacing" || (key == "ElementSize" && !spaced_)) {
      const auto spacing = lines_.numbers(value, axes());
      for (size_t a = 0; a < axes_; ++a) image.spacing[int(a)] = spacing[a];
      spaced_ = true;
    } else if (key == "Offset" || key == "Origin" || key == "Position") {
      const auto origin = lines_.numbers(value, axes());
      for (size_t a = 0; a < axes_; ++a) image.origin[int(a)] = origin[a];
    } else if (key == "TransformMatrix" || key == "Rotation" || key == "Orientation") {
      const auto matrix = lines_.numbers(value, axes() * axes_);  // one row for each axis of the image
      for (size_t a = 0; a < axes_; ++a)
        for (size_t w = 0; w < axes_; ++w) image.direction[3 * w + a] = matrix[a * axes_ + w];
    } else if (key == "ElementType") {
      header_.type = typeOfMetaWord(value, lines_);
      typed_ = true;
    } else if (key == "ElementNumberOfChannels") {
      header_.components = int(lines_.integer(value, 1, 1024));
    } else if (key == "BinaryDataByteOrderMSB" || key == "ElementByteOrderMSB") {
      header_.swapBytes = yes != (std::endian::native == std::endian::big);
    } else if (key == "CompressedData") {
      header_.compression = yes ? Compression::Zlib : Compression::None;
    } else if (key == "BinaryData") {
      header_.text = !yes;
    } else if (key == "HeaderSize") {
      header_.offset = lines_.integer(value, -1, int64_t(1) << 53);
    }
  }

  void finish(const std::string& file) {
    if (!sized_ || !typed_) lines_.fail("expected DimSize and ElementType before ElementDataFile");
    if (file == "LIST" || file.starts_with("LIST ") || file.find('%') != file.npos)
      lines_.fail("the samples are in a file for each slice; read are images in one file");
    if (file.empty()) lines_.fail("expected the name of a file, or LOCAL");
    if (lowerCase(file) == "local")
      header_.offset =
          header_.offset == ImageHeader::kAtEnd ? ImageHeader::kAtEnd : int64_t(lines_.position());
    else
      header_.dataFile = file;
  }

  size_t axes() const {
    if (axes_ == 0) lines_.fail("expected NDims first");
    return axes_;
  }

  HeaderLines lines_;
  ImageHeader header_;
  size_t axes_ = 0;
  bool sized_ = false, typed_ = false, spaced_ = false;
};

}  // namespace

ImageHeader parseMetaImage(std::string_view bytes, const std::string& where) {
  return MetaImage(bytes, where).take();
}

}  // namespace gxy
