// SPDX-License-Identifier: Apache-2.0
#include "core/io/vtk_xml_array.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>
#include <vector>

#include "core/comm/error.h"
#include "core/io/number_text.h"

namespace gxy {
namespace {

using Form = XmlPlace::Form;

/// Returns the decoded bytes at `position`, from number `from` on.
ByteStreamPtr bytesFrom(const std::shared_ptr<const File>& file, Form form, int64_t position, int64_t from,
                        int64_t bytes) {
  if (form == Form::Raw) return fileBytes(file, position + from, bytes);
  constexpr int64_t kBytes = 3, kCharacters = 4;
  const int64_t group = from / kBytes;
  ByteStreamPtr stream =
      decodedBase64(fileBytes(file, position + group * kCharacters, std::numeric_limits<int64_t>::max() / 2));
  std::byte before[kBytes];
  stream->read(std::span(before).first(size_t(from % kBytes)));
  return stream;
}

/// Whether some writer has broken base64 into lines. `position` is that of the first character.
bool isInLines(const std::shared_ptr<const File>& file, int64_t position, int64_t bytes) {
  constexpr int64_t kMostOfLine = 4096;
  std::array<std::byte, size_t(kMostOfLine)> text;
  const auto used = std::span(text).first(size_t(std::min((bytes + 2) / 3 * 4, kMostOfLine)));
  const size_t n = fileBytes(file, position, int64_t(used.size()))->read(used);
  return std::any_of(used.begin(), used.begin() + std::ptrdiff_t(n),
                     [](std::byte c) { return std::isspace(int(c)) != 0; });
}

/// The first bytes of another stream.
class FirstBytes final : public ByteStream {
 public:
  FirstBytes(ByteStreamPtr from, int64_t bytes) : from_(std::move(from)), left_(bytes) {}
  size_t read(std::span<std::byte> out) override {
    const size_t n = from_->read(out.first(size_t(std::min<int64_t>(left_, int64_t(out.size())))));
    left_ -= int64_t(n);
    return n;
  }

 private:
  ByteStreamPtr from_;
  int64_t left_;
};

/// Reads the words of an array's header.
class ArrayHeader {
 public:
  ArrayHeader(const VtkXml& xml, const XmlPlace& place)
      : stream_(
            bytesFrom(xml.file(), place.form, place.position, 0, std::numeric_limits<int64_t>::max() / 2)),
        width_(size_t(xml.headerWordBytes())),
        swap_(xml.swapsBytes()) {}
  uint64_t word() {
    std::byte bytes[8] = {};
    const std::span used(bytes, width_);
    stream_->read(used);
    if (swap_) swapBytes(used, width_);
    ++words_;
    if (width_ == 8) return std::bit_cast<uint64_t>(bytes);
    uint32_t narrow;
    std::memcpy(&narrow, bytes, 4);
    return narrow;
  }
  bool isNarrow() const { return width_ == 4; }
  int64_t bytes() const { return int64_t(words_ * width_); }

 private:
  ByteStreamPtr stream_;
  size_t width_, words_ = 0;
  bool swap_;
};

class Uncompressed final : public BlockedBytes {
 public:
  Uncompressed(std::shared_ptr<const File> file, XmlPlace place, int64_t header, int64_t bytes)
      : file_(std::move(file)), place_(place), header_(header), bytes_(bytes) {
    // Nobody knows where a later block of lines begins.
    if (place.form != Form::Raw && isInLines(file_, place.position, header + bytes))
      blockBytes_ = std::max<int64_t>(bytes, 1);
  }
  int64_t bytes() const override { return bytes_; }
  int64_t blockBytes() const override { return blockBytes_; }
  ByteStreamPtr open(int64_t block) const override {
    return bytesFrom(file_, place_.form, place_.position, header_ + block * blockBytes(), blockBytes());
  }

 private:
  std::shared_ptr<const File> file_;
  XmlPlace place_;
  int64_t header_, bytes_, blockBytes_ = int64_t(1) << 18;
};

class Compressed final : public BlockedBytes {
 public:
  Compressed(const VtkXml& xml, const XmlPlace& place, Compression compression, int64_t bytes,
             std::string where)
      : file_(xml.file()), place_(place), compression_(compression), bytes_(bytes), where_(std::move(where)) {
    ArrayHeader header(xml, place);
    const uint64_t blocks = header.word(), size = header.word();
    header.word();  // size of the last block, which follows from the total
    blockBytes_ = int64_t(std::min<uint64_t>(size, uint64_t(std::max<int64_t>(bytes, 1))));
    starts_.push_back(0);
    for (uint64_t i = 0; i < blocks; ++i) starts_.push_back(starts_.back() + int64_t(header.word()));
    if (place.form != Form::Raw && isInLines(file_, place.position, header.bytes() + starts_.back()))
      throw Error(where_ + ": compressed base64 in lines, expected no white space between its characters");
    // The header is encoded separately from the data.
    place_.position += place.form == Form::Raw ? header.bytes() : (header.bytes() + 2) / 3 * 4;
  }
  int64_t bytes() const override { return bytes_; }
  int64_t blockBytes() const override { return blockBytes_; }
  ByteStreamPtr open(int64_t block) const override {
    const int64_t start = starts_[size_t(block)], stored = starts_[size_t(block) + 1] - start;
    return decompressed(
        std::make_unique<FirstBytes>(bytesFrom(file_, place_.form, place_.position, start, stored), stored),
        compression_, where_);
  }

 private:
  std::shared_ptr<const File> file_;
  XmlPlace place_;
  Compression compression_;
  int64_t bytes_, blockBytes_ = 1;
  std::vector<int64_t> starts_;  ///< start of each block, then the end of the last
  std::string where_;
};

Compression compressionOf(const VtkXml& xml) {
  const std::string name = attribute(xml.root(), "compressor");
  if (name == "vtkZLibDataCompressor") return Compression::Zlib;
  if (name == "vtkLZ4DataCompressor") return Compression::Lz4;
  if (name == "vtkLZMADataCompressor") return Compression::Lzma;
  throw Error(xml.path() + ": compressed by '" + name +
              "', expected vtkZLibDataCompressor, vtkLZ4DataCompressor or vtkLZMADataCompressor");
}

}  // namespace

std::shared_ptr<const BlockedBytes> xmlArrayBytes(const VtkXml& xml, vtkXMLDataElement* array,
                                                  ScalarType type, int64_t bytes) {
  const XmlPlace place = xml.placeOf(array);
  const std::string where = xml.path() + ": array '" + attribute(array, "Name") + "'";
  if (place.form == Form::Text) return textBlocks(xml.file(), place.position, type, bytes, where);
  if (xml.compressed()) return std::make_shared<Compressed>(xml, place, compressionOf(xml), bytes, where);
  ArrayHeader header(xml, place);
  const uint64_t stated = header.word();
  // Writers let the 32-bit size wrap above 4 GiB.
  if (stated != (header.isNarrow() ? uint64_t(uint32_t(bytes)) : uint64_t(bytes)))
    throw Error(where + " has " + std::to_string(stated) + " bytes, expected " + std::to_string(bytes));
  return std::make_shared<Uncompressed>(xml.file(), place, header.bytes(), bytes);
}

bool readXmlArray(const VtkXml& xml, vtkXMLDataElement* array, ScalarType type, std::span<std::byte> out) {
  if (out.empty()) return true;  // Some writers leave out an empty array's header.
  const bool text = xml.placeOf(array).form == Form::Text;
  const int64_t bytes = text ? int64_t(out.size()) : xml.dataBytes(array);
  if (bytes < int64_t(out.size())) return false;
  if (readBlocks(*xmlArrayBytes(xml, array, type, bytes), 0, out) < out.size()) return false;
  if (!text && xml.swapsBytes()) swapBytes(out, bytesOf(type));
  return true;
}

}  // namespace gxy
