// SPDX-License-Identifier: Apache-2.0
// Streams that decode bytes of files piece by piece. None of them holds more than some hundred kilobytes,
// whatever sizes a file states. Used inside core/io only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/io/file.h"

namespace gxy {

/// A sequence of bytes. One thread at a time may use it.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Fills `out` from its beginning and returns the number of bytes; it is less than the size of `out`
  /// only at the end.
  virtual size_t read(std::span<std::byte> out) = 0;
};
using ByteStreamPtr = std::unique_ptr<ByteStream>;

/// The `bytes` bytes of a file from `offset` on, or fewer if the file ends before.
ByteStreamPtr fileBytes(std::shared_ptr<const File> file, int64_t offset, int64_t bytes);

/// Decodes base64 text up to its padding or the first character that is not base64. White space is skipped.
ByteStreamPtr decodedBase64(ByteStreamPtr text);

/// The form of compressed bytes: `Zlib` is zlib's or gzip's, `Lz4` one LZ4 block, `Lzma` an .xz stream.
enum class Compression { None, Zlib, Lz4, Lzma };

/// Decompresses bytes. read() throws Error, which begins with `where`, for bytes that are not in that form.
ByteStreamPtr decompressed(ByteStreamPtr bytes, Compression compression, const std::string& where);

/// Bytes in blocks of one size; the last block may be smaller. Each block can be decoded by itself, from its
/// beginning. Any thread may use it.
class BlockedBytes {
 public:
  virtual ~BlockedBytes() = default;
  virtual int64_t bytes() const = 0;       ///< decoded size of all blocks
  virtual int64_t blockBytes() const = 0;  ///< decoded size of each block but the last; positive
  virtual ByteStreamPtr open(int64_t block) const = 0;
};

/// Decodes the blocks from number `first` on, on all cores, until `out` is full. Returns the number of bytes before the first
/// block that ends too early; the size of `out` if none does. If blocks cannot be decoded, it throws what the first of them
/// throws, whichever comes to be decoded first.
size_t readBlocks(const BlockedBytes& bytes, int64_t first, std::span<std::byte> out);

/// The `bytes` bytes of a file from `offset` on, compressed as one block. The result has `decoded` bytes of
/// the decompressed ones, after the first `passed`.
std::shared_ptr<const BlockedBytes> oneBlock(std::shared_ptr<const File> file, int64_t offset, int64_t bytes,
                                             Compression compression, int64_t passed, int64_t decoded);

}  // namespace gxy
