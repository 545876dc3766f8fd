// SPDX-License-Identifier: Apache-2.0
// Bytes of files, decoded piece by piece: none of these holds more than some hundred kilobytes, whatever a file states. Used
// inside core/io only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/io/file.h"

namespace gxy {

/// Bytes one after the other, for one thread at a time.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Fills `out` from its beginning and returns how many bytes there were: fewer than asked for only at the end.
  virtual size_t read(std::span<std::byte> out) = 0;
};
using ByteStreamPtr = std::unique_ptr<ByteStream>;

/// `bytes` bytes of a file from `offset` on, or fewer where the file ends before.
ByteStreamPtr fileBytes(std::shared_ptr<const File> file, int64_t offset, int64_t bytes);

/// What base64 text holds, up to its padding or the first character that is none of base64's. White space is passed over.
ByteStreamPtr decodedBase64(ByteStreamPtr text);

/// How bytes are compressed: `Zlib` in the form of zlib or of gzip, `Lz4` as one LZ4 block, `Lzma` as an .xz stream.
enum class Compression { None, Zlib, Lz4, Lzma };

/// What compressed bytes become. Its read() throws Error, which begins with `where`, for bytes that are not in that form.
ByteStreamPtr decompressed(ByteStreamPtr bytes, Compression compression, const std::string& where);

/// Bytes in blocks of one size, the last of which may be smaller; each can be decoded by itself, from its beginning. Safe from any
/// thread.
class BlockedBytes {
 public:
  virtual ~BlockedBytes() = default;
  virtual int64_t bytes() const = 0;       ///< decoded, of all blocks
  virtual int64_t blockBytes() const = 0;  ///< decoded, of each but the last; positive
  virtual ByteStreamPtr open(int64_t block) const = 0;
};

/// `bytes` bytes of a file from `offset` on, compressed as one block: of what they become, `decoded` bytes behind the first `passed`.
std::shared_ptr<const BlockedBytes> oneBlock(std::shared_ptr<const File> file, int64_t offset, int64_t bytes,
                                             Compression compression, int64_t passed, int64_t decoded);

}  // namespace gxy
