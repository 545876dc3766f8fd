// SPDX-License-Identifier: Apache-2.0
#include "core/io/vtk_xml.h"

#include <vtkInputStream.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/io/vtk_messages.h"
#include "core/io/vtk_scalars.h"

namespace gxy {
namespace {

/// VTK's readers decide this by "offset", not by "format".
bool isAppended(vtkXMLDataElement* array) { return array->GetAttribute("offset"); }
bool isText(vtkXMLDataElement* array) { return !isAppended(array) && attribute(array, "format") != "binary"; }

/// VTK's parser needs some 2.5 kB for each element, and visits nested elements by recursion.
constexpr size_t kMostElements = size_t(1) << 16, kDeepest = 64;

/// VTK's parser with a limit on elements. It also reads the headers of arrays, from the same place and
/// through the same stream as VTK's parser reads the arrays.
class Parser final : public vtkXMLDataParser {
 public:
  static Parser* New() { VTK_STANDARD_NEW_BODY(Parser); }

  using vtkXMLDataParser::Parse;
  /// Parses once, however often a reader that has been given the parser wants it.
  int Parse() override {
    if (!result_) result_ = vtkXMLDataParser::Parse();
    return *result_;
  }

  /// Throws the exception that ended the parsing, if any.
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

  /// From now on, <Piece> elements are stored as the names of their files only, without an element each.
  void listPieces() { listsPieces_ = true; }
  const std::vector<std::string>& pieces() const { return pieces_; }

  bool endedEarly() const { return elements_ > kMostElements || deepest_ > kDeepest; }

  size_t headerWordBytes() const { return HeaderType == 64 ? 8 : 4; }

  /// Moves to the header of an array that is not text.
  void seekHeader(vtkXMLDataElement* array) {
    Stream->clear();
    DataStream = isAppended(array) ? AppendedDataStream : InlineDataStream;
    if (isAppended(array)) {
      vtkTypeInt64 offset = 0, place;
      array->GetScalarAttribute("offset", offset);
      SeekG(__builtin_add_overflow(AppendedDataPosition, offset, &place) ? -1 : place);
    } else {
      SeekInlineDataPosition(array);
    }
    DataStream->SetStream(Stream);
    DataStream->StartReading();
  }

  /// Returns the position of text or base64 inside the element.
  int64_t placeOfInline(vtkXMLDataElement* array) {
    Stream->clear();
    SeekInlineDataPosition(array);
    return TellG();
  }

  /// Returns the next word of the header; nothing if the file or the base64 text ends before.
  std::optional<uint64_t> headerWord() {
    std::array<std::byte, 8> bytes;
    if (DataStream->Read(bytes.data(), headerWordBytes()) < headerWordBytes()) return {};
    PerformByteSwap(bytes.data(), 1, headerWordBytes());
    if (headerWordBytes() == 8) return std::bit_cast<uint64_t>(bytes);
    uint32_t narrow;
    std::memcpy(&narrow, bytes.data(), 4);
    return narrow;
  }

 protected:
  void StartElement(const char* name, const char** attributes) override {
    if (inPiece_ > 0 || (listsPieces_ && std::strcmp(name, "Piece") == 0)) {
      if (inPiece_++ == 0) addPiece(attributes);
      return;
    }
    vtkXMLDataParser::StartElement(name, attributes);
    ++elements_;
    deepest_ = std::max(deepest_, size_t(NumberOfOpenElements));
  }
  void EndElement(const char* name) override {
    if (inPiece_ > 0)
      --inPiece_;
    else
      vtkXMLDataParser::EndElement(name);
  }
  /// Keeps the text of elements other than arrays, which are read from the file.
  void CharacterDataHandler(const char* data, int length) override {
    if (NumberOfOpenElements > 0 &&
        std::strcmp(OpenElements[NumberOfOpenElements - 1]->GetName(), "DataArray") != 0)
      vtkXMLDataParser::CharacterDataHandler(data, length);
  }
  int ParseBuffer(const char* buffer, unsigned int count) override {
    constexpr uint64_t kWatched = uint64_t(1) << 20;
    const uint64_t before = std::exchange(parsed_, parsed_ + count);
    if (before / kWatched != parsed_ / kWatched) {
      try {
        ReadWatch::check();
      } catch (...) {  // No exception may pass through the parser.
        thrown_ = std::current_exception();
        return 0;
      }
    }
    return vtkXMLDataParser::ParseBuffer(buffer, count) && !endedEarly();
  }

 private:
  void addPiece(const char** attributes) {
    std::string source;
    for (; attributes[0] && attributes[1]; attributes += 2)
      if (std::strcmp(attributes[0], "Source") == 0) source = attributes[1];
    pieces_.push_back(std::move(source));
  }

  std::optional<int> result_;
  size_t elements_ = 0, deepest_ = 0, inPiece_ = 0;
  bool listsPieces_ = false;
  std::vector<std::string> pieces_;
  uint64_t parsed_ = 0;
  std::exception_ptr thrown_;
};

/// Returns the position where the array's text ends at the latest: where the next element of its parent
/// begins, or else the end of the file.
int64_t endOfText(vtkXMLDataElement* array, int64_t fileBytes) {
  vtkXMLDataElement* parent = array->GetParent();
  for (int i = 0; parent && i + 1 < parent->GetNumberOfNestedElements(); ++i)
    if (parent->GetNestedElement(i) == array) return parent->GetNestedElement(i + 1)->GetXMLByteIndex();
  return fileBytes;
}

/// VTK's parser needs 24 bytes of memory for each block. Writers make blocks of some kilobytes.
constexpr uint64_t kSmallestBlock = 64;

Parser& of(vtkXMLDataParser* parser) { return static_cast<Parser&>(*parser); }

}  // namespace

std::string attribute(vtkXMLDataElement* element, const char* name) {
  const char* value = element->GetAttribute(name);
  return value ? value : "";
}

VtkXml::VtkXml(const std::string& path, const char* type)
    : file_(std::make_shared<const File>(File::open(path))),
      stream_(std::make_unique<std::ifstream>(file_->opened(), std::ios::binary)),
      parser_(vtkSmartPointer<Parser>::New()) {
  const VtkMessages messages;
  parser_->SetStream(stream_.get());
  constexpr std::array<std::string_view, 4> kLists{"PUnstructuredGrid", "PPolyData", "PStructuredGrid",
                                                   "PRectilinearGrid"};
  if (std::find(kLists.begin(), kLists.end(), type) != kLists.end()) of(parser_).listPieces();
  const bool parsed = parser_->Parse();
  of(parser_).rethrow();
  if (of(parser_).endedEarly())
    throw Error(path + ": too many XML elements, expected at most " + std::to_string(kMostElements) +
                " and at most " + std::to_string(kDeepest) + " in one another");
  messages.check(path);
  if (!parsed || !root()) throw Error(path + ": not an XML file");
  if (std::strcmp(root()->GetName(), "VTKFile") != 0 || attribute(root(), "type") != type)
    throw Error(path + ": expected a VTK XML file of type " + type + ", found '" + attribute(root(), "type") +
                "'");
  data_ = root()->FindNestedElementWithName(type);
  if (!data_) throw Error(path + ": element <" + type + "> is missing");
}

const std::vector<std::string>& VtkXml::listedPieces() const { return of(parser_).pieces(); }

bool VtkXml::compressed() const { return !attribute(root(), "compressor").empty(); }

int64_t VtkXml::headerWordBytes() const { return int64_t(of(parser_).headerWordBytes()); }

bool VtkXml::swapsBytes() const {
  return (attribute(root(), "byte_order") == "BigEndian") != (std::endian::native == std::endian::big);
}

XmlPlace VtkXml::placeOf(vtkXMLDataElement* array) const {
  using Form = XmlPlace::Form;
  if (!isAppended(array))
    return {isText(array) ? Form::Text : Form::Base64, of(parser_).placeOfInline(array)};
  int64_t place = 0;
  const std::string offset = attribute(array, "offset");
  if (std::from_chars(offset.data(), offset.data() + offset.size(), place).ec != std::errc() || place < 0 ||
      place > file_->size())
    fail(array, "begins at offset " + offset + ", which is no position in the file");
  vtkXMLDataElement* appended = root()->FindNestedElementWithName("AppendedData");
  if (!appended) fail(array, "has no data: there is no <AppendedData>");
  return {attribute(appended, "encoding") == "raw" ? Form::Raw : Form::Base64,
          parser_->GetAppendedDataPosition() + place};
}

void VtkXml::fail(vtkXMLDataElement* array, const std::string& what) const {
  throw Error(path() + ": array '" + attribute(array, "Name") + "' " + what);
}

int64_t VtkXml::dataBytes(vtkXMLDataElement* array) const {
  const auto fileBytes = uint64_t(file_->size());
  if (isText(array))  // Each number has at least a digit and a space.
    return statedBytes(array, (endOfText(array, file_->size()) - array->GetXMLByteIndex()) / 2);
  Parser& parser = of(parser_);
  parser.seekHeader(array);
  const auto word = [&] {
    const std::optional<uint64_t> next = parser.headerWord();
    if (!next) fail(array, "has no data: the file ends before");
    return *next;
  };
  if (!compressed()) return int64_t(std::min(word(), fileBytes));
  const uint64_t blocks = word(), size = word(), last = word();
  if (blocks == 0) return 0;
  const auto text = [](uint64_t n) { return std::to_string(n); };
  if (blocks > fileBytes / parser.headerWordBytes())
    fail(array, "is compressed in " + text(blocks) + " blocks, whose sizes the file cannot hold");
  if (size == 0 || last > size || (blocks > 1 && size < kSmallestBlock))
    fail(array, "is compressed in " + text(blocks) + " blocks of " + text(size) + " bytes, the last of " +
                    text(last) + ", expected " + text(kSmallestBlock) + " or more, and no more in the last");
  uint64_t bytes;
  if (__builtin_mul_overflow(blocks - 1, size, &bytes) ||
      __builtin_add_overflow(bytes, last ? last : size, &bytes) ||
      bytes > uint64_t(std::numeric_limits<int64_t>::max()))
    fail(array, "is compressed in " + text(blocks) + " blocks of " + text(size) + " bytes: too many");
  for (uint64_t block = 0; block < blocks; ++block)
    if (const uint64_t stored = word(); stored > fileBytes)
      fail(array, "is compressed to " + text(stored) + " bytes in block " + text(block) +
                      ", more than the file has");
  return int64_t(bytes);
}

int64_t VtkXml::statedBytes(vtkXMLDataElement* array, int64_t tuples) const {
  const std::string word = attribute(array, "type");
  const auto type = scalarOfXmlWord(word);
  if (!type && word != "Bit") return 0;
  int components = 1;
  if (array->GetAttribute("NumberOfComponents") &&
      (!array->GetScalarAttribute("NumberOfComponents", components) || components < 1))
    fail(array, "has " + attribute(array, "NumberOfComponents") + " components, expected one or more");
  int64_t bytes;
  if (__builtin_mul_overflow(tuples, int64_t(components), &bytes) ||
      __builtin_mul_overflow(bytes, int64_t(type ? bytesOf(*type) : 1), &bytes))
    fail(array, "has too many values: " + std::to_string(tuples) + " entries of " +
                    std::to_string(components) + " components");
  return type ? bytes : bytes / 8 + (bytes % 8 > 0);
}

void VtkXml::checkFileHolds(vtkXMLDataElement* array, int64_t bytes) const {
  if (isText(array)) {
    const auto type = scalarOfXmlWord(attribute(array, "type"));
    const int64_t characters = endOfText(array, file_->size()) - array->GetXMLByteIndex();
    // Each number has at least a digit, and a space before the next.
    if (const int64_t values = type ? bytes / int64_t(bytesOf(*type)) : 0; values > (characters + 1) / 2)
      fail(array, "has " + std::to_string(values) + " values, more than its " + std::to_string(characters) +
                      " characters can be");
  } else if (!compressed() && bytes > file_->size()) {
    fail(array, "has " + std::to_string(bytes) + " bytes, more than the file, which has " +
                    std::to_string(file_->size()));
  }
}

void VtkXml::checkCompressed(vtkXMLDataElement* array, int64_t bytes) const {
  if (!compressed() || isText(array)) return;
  of(parser_).seekHeader(array);
  if (bytes == 0 && !of(parser_).headerWord()) return;  // Some writers leave out an empty array's header.
  if (const int64_t found = dataBytes(array); found != bytes)
    fail(array, "has " + std::to_string(found) + " bytes when it is decompressed, expected " +
                    std::to_string(bytes));
}

}  // namespace gxy
