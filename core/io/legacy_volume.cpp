// SPDX-License-Identifier: Apache-2.0
// Reads legacy VTK structured points (VTK user's guide, "Simple Legacy Formats"). One pass over the file
// finds the places of its arrays; samples are later read from there.
#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>
#include <optional>
#include <set>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/byte_stream.h"
#include "core/io/file.h"
#include "core/io/image_volume.h"
#include "core/io/number_text.h"
#include "core/io/raw_samples.h"
#include "core/io/streamed_samples.h"
#include "core/io/volume_formats.h"
#include "core/io/word_reader.h"

namespace gxy {
namespace {

std::string upperCase(std::string text) {
  for (char& c : text) c = char(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::optional<ScalarType> typeOfLegacyWord(const std::string& word) {
  constexpr std::pair<const char*, ScalarType> kWords[] = {{"CHAR", ScalarType::Int8},
                                                           {"SIGNED_CHAR", ScalarType::Int8},
                                                           {"UNSIGNED_CHAR", ScalarType::UInt8},
                                                           {"SHORT", ScalarType::Int16},
                                                           {"UNSIGNED_SHORT", ScalarType::UInt16},
                                                           {"INT", ScalarType::Int32},
                                                           {"VTKIDTYPE", ScalarType::Int32},
                                                           {"UNSIGNED_INT", ScalarType::UInt32},
                                                           {"LONG", ScalarType::Int64},
                                                           {"VTKTYPEINT64", ScalarType::Int64},
                                                           {"UNSIGNED_LONG", ScalarType::UInt64},
                                                           {"VTKTYPEUINT64", ScalarType::UInt64},
                                                           {"FLOAT", ScalarType::Float32},
                                                           {"DOUBLE", ScalarType::Float64}};
  for (const auto& [name, type] : kWords)
    if (word == name) return type;
  return {};
}

/// Decodes "%20" and similar codes in names.
std::string decodedName(const std::string& name) {
  std::string text;
  for (size_t i = 0; i < name.size(); ++i) {
    const auto digit = [&](size_t k) {
      return k < name.size() && std::isxdigit(static_cast<unsigned char>(name[k]));
    };
    if (name[i] == '%' && digit(i + 1) && digit(i + 2)) {
      text += char(std::stoi(name.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += name[i];
    }
  }
  return text;
}

/// Colours of text files, which have fractions where binary files have bytes.
class ColourFractions final : public SampleSource {
 public:
  explicit ColourFractions(std::shared_ptr<const SampleSource> floats, int components)
      : floats_(std::move(floats)), components_(components) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    std::vector<std::byte> fractions, colours;
    floats_->read(wanted, [&](const SamplesRead& some) {
      const size_t point = sizeof(float) * size_t(components_);
      fractions.resize(size_t(some.points.count()) * point);
      copyBox(some.points, some.samples, some.layout, fractions, some.points, point);
      colours.clear();
      for (size_t at = 0; at < fractions.size(); at += sizeof(float)) {
        float fraction;
        std::memcpy(&fraction, &fractions[at], sizeof fraction);
        colours.push_back(std::byte(fraction > 0 ? std::min(fraction, 1.f) * 255 + 0.5f : 0.f));
      }
      take({some.wanted, some.points, some.points, colours});
    });
  }

 private:
  std::shared_ptr<const SampleSource> floats_;
  int components_;
};

/// The description of a file's image, and the places of its arrays.
class LegacyImage {
 public:
  explicit LegacyImage(const std::string& path)
      : file_(std::make_shared<const File>(File::open(path))), words_(file_) {
    image_.path = path;
    readHeader();
    while (readSection()) {
    }
    if (!(image_.points[0] > 0)) words_.fail("the file ends, expected DIMENSIONS");
  }

  VolumeFile volume(const std::string& wanted) {
    return volumeOf(image_, wanted, [this](const ArrayInfo& array) { return samplesOf(array); });
  }

 private:
  enum class Of { Nothing, Points, Cells };

  void readHeader() {
    const std::string first = words_.line();
    if (!upperCase(first).starts_with("# VTK DATAFILE VERSION"))
      words_.fail("expected a legacy VTK file, which begins with \"# vtk DataFile Version\"");
    words_.line();  // title
    const std::string form = keyword("ASCII or BINARY");
    if (form != "ASCII" && form != "BINARY")
      words_.fail("found " + inQuotes(form) + ", expected ASCII or BINARY");
    binary_ = form == "BINARY";
  }

  std::string keyword(const char* expected) {
    const std::string word = upperCase(words_.word());
    if (word.empty()) words_.fail(std::string("the file ends, expected ") + expected);
    return word;
  }
  double number() {
    const std::string word = words_.word();
    const auto value = valueOfText(word);
    if (!value) words_.fail("found " + inQuotes(word) + ", expected a number");
    return *value;
  }
  int64_t integer(int64_t least, int64_t most, const char* what) {
    const double value = number();
    if (!(value >= double(least) && value <= double(most)) || value != double(int64_t(value)))
      words_.fail(std::string("expected ") + what + " from " + std::to_string(least) + " to " +
                  std::to_string(most));
    return int64_t(value);
  }

  /// Reads one section. Returns false at the end of the file.
  bool readSection() {
    const std::string word = upperCase(words_.word());
    constexpr int64_t kMost = std::numeric_limits<int32_t>::max();
    if (word.empty()) return false;
    if (word == "DATASET") {
      const std::string kind = keyword("STRUCTURED_POINTS");
      if (kind != "STRUCTURED_POINTS")
        words_.fail("found " + inQuotes(kind) +
                    ", expected STRUCTURED_POINTS, or UNSTRUCTURED_GRID of tetrahedra");
    } else if (word == "DIMENSIONS") {
      for (int64_t& n : image_.points) n = integer(1, kMost, "a number of points");
    } else if (word == "EXTENT") {
      for (size_t a = 0; a < 3; ++a) {
        first_[int(a)] = double(integer(-kMost, kMost, "an index"));
        image_.points[a] = integer(int64_t(first_[int(a)]), kMost, "an index") - int64_t(first_[int(a)]) + 1;
      }
    } else if (word == "SPACING" || word == "ASPECT_RATIO") {
      for (int a = 0; a < 3; ++a) image_.spacing[a] = number();
    } else if (word == "ORIGIN") {
      for (int a = 0; a < 3; ++a) image_.origin[a] = number();
    } else if (word == "POINT_DATA" || word == "CELL_DATA") {
      beginData(word == "CELL_DATA");
    } else if (word == "METADATA") {
      skipMetadata();
    } else {
      return readAttribute(word);
    }
    return true;
  }

  /// Passes over lines up to an empty one.
  void skipMetadata() {
    words_.line();
    while (!words_.line().empty()) {
    }
  }

  void beginData(bool ofCells) {
    if (of_ == Of::Nothing) image_.origin = image_.placeOf(first_);
    of_ = ofCells ? Of::Cells : Of::Points;
    const Extent extent = image_.extentOf({{}, {}, 1, {}, ofCells});
    const int64_t stated = integer(0, std::numeric_limits<int64_t>::max() / 2, "a count");
    const int64_t expected = countOf(extent);
    if (stated != expected)
      words_.fail("arrays of " + std::to_string(stated) +
                  (ofCells ? " cells, expected " : " points, expected ") + std::to_string(expected));
  }

  int64_t countOf(const Extent& extent) const {
    int64_t count = 1;
    for (const int64_t n : extent.points)
      if (__builtin_mul_overflow(count, n, &count) || count > std::numeric_limits<int64_t>::max() / 1024)
        words_.fail("there are too many points");
    return count;
  }

  bool readAttribute(const std::string& word) {
    if (word == "FIELD") return readField();
    if (word == "LOOKUP_TABLE") {
      words_.word();
      const int64_t size = integer(0, std::numeric_limits<int32_t>::max(), "a size");
      skip(ScalarType::UInt8, 4 * size);
      return true;
    }
    if (of_ == Of::Nothing)
      words_.fail("found " + inQuotes(word) + ", expected a keyword of STRUCTURED_POINTS");
    const std::string name = decodedName(words_.word());
    if (word == "COLOR_SCALARS") {
      const int components = int(integer(1, 1024, "a number of components"));
      addArray(name, ScalarType::UInt8, components, pointsOrCells());
      if (!image_.arrays.empty()) colours_.insert(image_.arrays.size() - 1);
      return true;
    }
    int components = word == "TENSORS"                        ? 9
                     : word == "TENSORS6"                     ? 6
                     : word == "VECTORS" || word == "NORMALS" ? 3
                                                              : 1;
    if (word == "TEXTURE_COORDINATES")
      components = int(integer(1, 3, "a number of components"));
    else if (components == 1 && word != "SCALARS" && word != "GLOBAL_IDS" && word != "PEDIGREE_IDS" &&
             word != "EDGE_FLAGS")
      words_.fail("found " + inQuotes(word) + ", expected a kind of array");
    const std::string type = keyword("a type");
    if (word == "SCALARS") {
      const std::string rest = words_.restOfLine();
      if (!rest.empty()) {
        const auto value = valueOfText(rest);
        if (!value || !(*value >= 1 && *value <= 1024))
          words_.fail("found " + inQuotes(rest) + ", expected a number of components from 1 to 1024");
        components = int(*value);
      }
      if (keyword("LOOKUP_TABLE") != "LOOKUP_TABLE") words_.fail("expected LOOKUP_TABLE after SCALARS");
      words_.word();
      std::string& active = of_ == Of::Cells ? image_.activeOfCells : image_.active;
      if (active.empty()) active = name;
    }
    return addTyped(name, type, components, pointsOrCells());
  }

  int64_t pointsOrCells() const { return image_.extentOf({{}, {}, 1, {}, of_ == Of::Cells}).count(); }

  bool readField() {
    words_.word();  // its name
    for (int64_t arrays = integer(0, 1 << 20, "a number of arrays"); arrays > 0; --arrays) {
      std::string name = words_.word();
      for (; upperCase(name) == "METADATA"; name = words_.word()) skipMetadata();  // of the array before
      const int64_t components = integer(0, 1 << 16, "a number of components");
      const int64_t tuples = integer(0, int64_t(1) << 40, "a number of tuples");
      if (!addTyped(decodedName(name), keyword("a type"), components, tuples)) return false;
    }
    return true;
  }

  /// Adds an array. Returns false if the place of the data after it cannot be determined.
  bool addTyped(const std::string& name, const std::string& word, int64_t components, int64_t tuples) {
    if (word == "BIT") {
      if (binary_) words_.dataBegins();
      binary_ ? words_.skipBytes((components * tuples + 7) / 8) : words_.skipWords(components * tuples);
      return true;
    }
    const auto type = typeOfLegacyWord(word);
    if (!type) {
      image_.warnings.push_back(image_.path + ": array " + inQuotes(name) + " is of type " + inQuotes(word) +
                                ": it and what follows it are not read");
      return false;
    }
    addArray(name, *type, components, tuples);
    return true;
  }

  void addArray(const std::string& name, ScalarType type, int64_t components, int64_t tuples) {
    if (binary_) words_.dataBegins();
    if (of_ != Of::Nothing && tuples == pointsOrCells() && components >= 1 && components <= 1024) {
      image_.arrays.push_back({name, type, int(components), {}, of_ == Of::Cells});
      places_.push_back(words_.position());
    }
    skip(type, components * tuples);
  }

  void skip(ScalarType type, int64_t values) {
    if (binary_) words_.dataBegins();
    binary_ ? words_.skipBytes(values * int64_t(bytesOf(type))) : words_.skipWords(values);
  }

  std::shared_ptr<const SampleSource> samplesOf(const ArrayInfo& array) const {
    size_t i = 0;
    while (image_.arrays[i].name != array.name || image_.arrays[i].ofCells != array.ofCells) ++i;
    const Extent extent = image_.extentOf(array);
    constexpr bool swaps = std::endian::native == std::endian::little;
    if (binary_)
      return std::make_shared<RawSamples>(file_, places_[i], extent, array.type, array.components, swaps,
                                          false);
    const bool colours = colours_.contains(i);
    const ScalarType type = colours ? ScalarType::Float32 : array.type;
    const int64_t bytes = extent.count() * int64_t(bytesOf(type)) * array.components;
    const std::string where = image_.path + ": array '" + array.name + "'";
    auto samples =
        std::make_shared<StreamedSamples>(textBlocks(file_, places_[i], type, bytes, where), extent, type,
                                          array.components, false, where, image_.decoded);
    if (colours) return std::make_shared<ColourFractions>(std::move(samples), array.components);
    return samples;
  }

  std::shared_ptr<const File> file_;
  WordReader words_;
  ImageData image_;
  glm::dvec3 first_{0};  ///< index of the first point
  std::vector<int64_t> places_;
  std::set<size_t> colours_;  ///< indices of the arrays that are colours
  bool binary_ = false;
  Of of_ = Of::Nothing;
};

}  // namespace

VolumeFile openLegacyVolume(const std::string& path, const std::string& array) {
  return LegacyImage(path).volume(array);
}

}  // namespace gxy
