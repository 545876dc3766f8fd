// SPDX-License-Identifier: Apache-2.0
#include "core/io/byte_stream.h"

#include <lzma.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <exception>
#include <string_view>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/io/lz4_block.h"

namespace gxy {
namespace {

constexpr size_t kInput = size_t(64) << 10;  ///< bytes that decoders read at a time

class FileBytes final : public ByteStream {
 public:
  FileBytes(std::shared_ptr<const File> file, int64_t offset, int64_t bytes)
      : file_(std::move(file)), at_(offset), end_(offset + std::min(bytes, file_->size() - offset)) {}
  size_t read(std::span<std::byte> out) override {
    const auto n = size_t(std::clamp<int64_t>(end_ - at_, 0, int64_t(out.size())));
    file_->readAt(at_, out.first(n));
    at_ += int64_t(n);
    return n;
  }

 private:
  std::shared_ptr<const File> file_;
  int64_t at_, end_;
};

/// The bytes that a decoder has read from a stream and not used yet.
class Input {
 public:
  explicit Input(ByteStreamPtr from) : from_(std::move(from)), buffer_(kInput) {}
  /// Returns at least one byte, or none at the end.
  std::span<const std::byte> peek() {
    if (at_ == filled_) {
      at_ = 0;
      filled_ = from_->read(buffer_);
    }
    return {buffer_.data() + at_, filled_ - at_};
  }
  void take(size_t n) { at_ += n; }

 private:
  ByteStreamPtr from_;
  std::vector<std::byte> buffer_;
  size_t at_ = 0, filled_ = 0;
};

class Base64Bytes final : public ByteStream {
 public:
  explicit Base64Bytes(ByteStreamPtr text) : text_(std::move(text)) {}

  size_t read(std::span<std::byte> out) override {
    size_t n = 0;
    while (n < out.size() && !ended_) {
      const auto text = text_.peek();
      ended_ = text.empty();
      size_t used = 0;
      while (used < text.size() && n < out.size() && !ended_) {
        if (held_ == 0) {
          const size_t groups = decodeGroups(text.subspan(used), out.subspan(n));
          used += 4 * groups, n += 3 * groups;
          if (used == text.size() || n == out.size()) break;
        }
        const int digit = kDigits[size_t(text[used])];
        ended_ = digit == kOther;
        if (ended_) break;
        used++;
        if (digit == kSpace) continue;
        bits_ = bits_ << 6 | uint32_t(digit);
        held_ += 6;
        if (held_ < 8) continue;
        held_ -= 8;
        out[n++] = std::byte(bits_ >> held_ & 0xff);
      }
      text_.take(used);
    }
    return n;
  }

 private:
  static constexpr int8_t kSpace = -1, kOther = -2;  ///< what is no digit is negative
  static constexpr std::array<int8_t, 256> kDigits = [] {
    std::array<int8_t, 256> digits;
    digits.fill(kOther);
    for (const char c : {' ', '\t', '\n', '\v', '\f', '\r'}) digits[size_t(c)] = kSpace;
    constexpr std::string_view kAll = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < kAll.size(); i++) digits[size_t(kAll[i])] = int8_t(i);
    return digits;
  }();

  /// Decodes groups of four digits into three bytes each, up to the first that has another character or no room. Returns
  /// their number.
  static size_t decodeGroups(std::span<const std::byte> text, std::span<std::byte> out) {
    const size_t most = std::min(text.size() / 4, out.size() / 3);
    for (size_t group = 0; group < most; group++) {
      const auto digit = [&](size_t i) { return int(kDigits[size_t(text[4 * group + i])]); };
      const int a = digit(0), b = digit(1), c = digit(2), d = digit(3);
      if ((a | b | c | d) < 0) return group;
      const uint32_t bits = uint32_t(a << 18 | b << 12 | c << 6 | d);
      for (size_t i = 0; i < 3; i++) out[3 * group + i] = std::byte(bits >> (16 - 8 * i) & 0xff);
    }
    return most;
  }

  Input text_;
  uint32_t bits_ = 0;
  int held_ = 0;  ///< number of the lowest bits of bits_ that have not become bytes yet
  bool ended_ = false;
};

/// A decoder that works in steps. A step uses some input, makes some output, and says whether the end has
/// been reached.
class Decoding : public ByteStream {
 public:
  Decoding(ByteStreamPtr from, std::string where) : from_(std::move(from)), where_(std::move(where)) {}

  size_t read(std::span<std::byte> out) final {
    size_t made = 0;
    while (made < out.size() && !ended_) {
      const auto in = from_.peek();
      const Step step = decode(in, out.subspan(made));
      from_.take(step.used);
      made += step.made;
      ended_ = step.ended;
      if (!ended_ && step.used + step.made == 0) fail(in.empty() ? "they end too early" : "they are damaged");
    }
    return made;
  }

 protected:
  struct Step {
    size_t used, made;
    bool ended;
  };
  virtual Step decode(std::span<const std::byte> in, std::span<std::byte> out) = 0;
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(where_ + ": its compressed data cannot be read: " + what);
  }

 private:
  Input from_;
  const std::string where_;
  bool ended_ = false;
};

class ZlibBytes final : public Decoding {
 public:
  ZlibBytes(ByteStreamPtr from, const std::string& where) : Decoding(std::move(from), where) {
    constexpr int kEitherForm = 32;
    if (inflateInit2(&state_, MAX_WBITS + kEitherForm) != Z_OK) fail("there is no memory for it");
  }
  ~ZlibBytes() override { inflateEnd(&state_); }

 private:
  Step decode(std::span<const std::byte> in, std::span<std::byte> out) override {
    constexpr size_t kMost = size_t(1) << 30;
    constexpr std::byte kGzip{0x1f};
    if (between_) {  // gzip's form allows several streams one after the other.
      if (in.empty() || in.front() != kGzip) return {0, 0, true};
      between_ = false;
      inflateReset(&state_);
    }
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(in.data()));
    state_.avail_in = uInt(in.size());
    state_.next_out = reinterpret_cast<Bytef*>(out.data());
    const size_t room = std::min(out.size(), kMost);
    state_.avail_out = uInt(room);
    const int result = inflate(&state_, Z_NO_FLUSH);
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR)
      fail(state_.msg ? state_.msg : "they are damaged");
    between_ = result == Z_STREAM_END;
    return {in.size() - state_.avail_in, room - state_.avail_out, false};
  }
  z_stream state_{};
  bool between_ = false;
};

class LzmaBytes final : public Decoding {
 public:
  LzmaBytes(ByteStreamPtr from, const std::string& where) : Decoding(std::move(from), where) {
    constexpr uint64_t kMostMemory = uint64_t(128) << 20;  // the strongest preset takes 65 MiB
    if (lzma_stream_decoder(&state_, kMostMemory, 0) != LZMA_OK) fail("there is no memory for it");
  }
  ~LzmaBytes() override { lzma_end(&state_); }

 private:
  Step decode(std::span<const std::byte> in, std::span<std::byte> out) override {
    state_.next_in = reinterpret_cast<const uint8_t*>(in.data());
    state_.avail_in = in.size();
    state_.next_out = reinterpret_cast<uint8_t*>(out.data());
    state_.avail_out = out.size();
    const lzma_ret result = lzma_code(&state_, LZMA_RUN);
    if (result == LZMA_MEMLIMIT_ERROR) fail("they need more than 128 MiB of memory");
    if (result != LZMA_OK && result != LZMA_STREAM_END && result != LZMA_BUF_ERROR) fail("they are damaged");
    return {in.size() - state_.avail_in, out.size() - state_.avail_out, result == LZMA_STREAM_END};
  }
  lzma_stream state_ = LZMA_STREAM_INIT;
};

class Lz4Bytes final : public Decoding {
 public:
  using Decoding::Decoding;

 private:
  Step decode(std::span<const std::byte> in, std::span<std::byte> out) override {
    const Lz4Block::Step step = block_.decode(in, out);
    if (step.damaged) fail("they are damaged");
    return {step.used, step.made, in.empty() && step.made == 0 && block_.mayEnd()};
  }
  Lz4Block block_;
};

class OneBlock final : public BlockedBytes {
 public:
  OneBlock(std::shared_ptr<const File> file, int64_t offset, int64_t bytes, Compression compression,
           int64_t passed, int64_t decoded)
      : file_(std::move(file)),
        offset_(offset),
        stored_(bytes),
        compression_(compression),
        passed_(passed),
        decoded_(decoded) {}
  int64_t bytes() const override { return decoded_; }
  int64_t blockBytes() const override { return std::max<int64_t>(decoded_, 1); }
  ByteStreamPtr open(int64_t) const override {
    ByteStreamPtr stream = decompressed(fileBytes(file_, offset_, stored_), compression_, file_->path());
    std::vector<std::byte> buffer(kInput);
    for (int64_t left = passed_; left > 0;) {
      const size_t n = stream->read(std::span(buffer).first(size_t(std::min(left, int64_t(kInput)))));
      if (n == 0) break;
      left -= int64_t(n);
    }
    return stream;
  }

 private:
  std::shared_ptr<const File> file_;
  int64_t offset_, stored_;
  Compression compression_;
  int64_t passed_, decoded_;
};

}  // namespace

ByteStreamPtr fileBytes(std::shared_ptr<const File> file, int64_t offset, int64_t bytes) {
  return std::make_unique<FileBytes>(std::move(file), offset, bytes);
}

ByteStreamPtr decodedBase64(ByteStreamPtr text) { return std::make_unique<Base64Bytes>(std::move(text)); }

size_t readBlocks(const BlockedBytes& bytes, int64_t first, std::span<std::byte> out) {
  constexpr size_t kTogether = size_t(8) << 20;  // bytes between two questions of ReadWatch
  const auto each = size_t(bytes.blockBytes());
  for (size_t at = 0; at < out.size();) {
    const size_t some = std::min(std::max(kTogether / each, size_t(1)) * each, out.size() - at);
    const size_t blocks = (some + each - 1) / each;
    std::vector<size_t> decoded(blocks);
    std::vector<std::exception_ptr> errors(blocks);
    const auto decode = [&](size_t i) {
      const std::span block = out.subspan(at + i * each, std::min(each, some - i * each));
      try {
        decoded[i] = bytes.open(first + int64_t(at / each + i))->read(block);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    };
    // The very first block comes before the others, so that what the bytes prepare when they are opened for the first time,
    // which may take all cores, does not begin inside the loop.
    const size_t alone = at == 0 ? 1 : 0;
    if (alone)
      decode(0);
    else
      ReadWatch::check();
    if (errors[0]) std::rethrow_exception(errors[0]);
    parallelFor(alone, blocks, [&](size_t i) {
      const ReadWatch none([] {});
      decode(i);
    });
    for (size_t i = 0; i < blocks; i++) {
      if (errors[i]) std::rethrow_exception(errors[i]);
      at += decoded[i];
      if (decoded[i] < std::min(each, some - i * each)) return at;
    }
  }
  return out.size();
}

ByteStreamPtr decompressed(ByteStreamPtr bytes, Compression compression, const std::string& where) {
  switch (compression) {
    case Compression::Zlib:
      return std::make_unique<ZlibBytes>(std::move(bytes), where);
    case Compression::Lz4:
      return std::make_unique<Lz4Bytes>(std::move(bytes), where);
    case Compression::Lzma:
      return std::make_unique<LzmaBytes>(std::move(bytes), where);
    case Compression::None:
      break;
  }
  return bytes;
}

std::shared_ptr<const BlockedBytes> oneBlock(std::shared_ptr<const File> file, int64_t offset, int64_t bytes,
                                             Compression compression, int64_t passed, int64_t decoded) {
  return std::make_shared<OneBlock>(std::move(file), offset, bytes, compression, passed, decoded);
}

}  // namespace gxy
