// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/tile_codec.h"

#include <cstdio>  // jpeglib.h needs FILE
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include <jpeglib.h>
#include <zlib.h>
#include <zstd.h>

#include "core/comm/error.h"

namespace gxy::protocol {

namespace {

constexpr int kZlibLevel = 1;
constexpr int kZstdLevel = 1;  // a tile of 256 KiB in well under a millisecond

// libjpeg ends the process on an error unless its handler does not return.
[[noreturn]] void failJpeg(j_common_ptr codec) {
  char message[JMSG_LENGTH_MAX];
  codec->err->format_message(codec, message);
  throw Error(std::string("JPEG data of a tile: ") + message);
}
void ignoreMessage(j_common_ptr) {}

jpeg_error_mgr throwingErrors() {
  jpeg_error_mgr errors;
  jpeg_std_error(&errors);
  errors.error_exit = failJpeg;
  errors.output_message = ignoreMessage;
  return errors;
}

Bytes encodeJpeg(std::span<const uint8_t> rgba, uint32_t w, uint32_t h, int quality) {
  jpeg_error_mgr errors = throwingErrors();
  jpeg_compress_struct codec;
  codec.err = &errors;
  jpeg_create_compress(&codec);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  const std::shared_ptr<void> release(nullptr, [&](void*) {
    jpeg_destroy_compress(&codec);
    std::free(out);
  });
  jpeg_mem_dest(&codec, &out, &size);
  codec.image_width = w;
  codec.image_height = h;
  codec.input_components = 3;
  codec.in_color_space = JCS_RGB;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  codec.dct_method = JDCT_FASTEST;
  jpeg_start_compress(&codec, TRUE);
  std::vector<uint8_t> row(size_t(w) * 3);
  for (uint32_t y = 0; y < h; y++) {
    for (uint32_t x = 0; x < w; x++) {
      const uint8_t* p = &rgba[(size_t(y) * w + x) * 4];
      for (int c = 0; c < 3; c++) row[size_t(x) * 3 + size_t(c)] = uint8_t((p[c] * p[3] + 127) / 255);
    }
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&codec, &rows, 1);
  }
  jpeg_finish_compress(&codec);
  const auto* first = reinterpret_cast<const std::byte*>(out);
  return Bytes(first, first + size);
}

std::vector<uint8_t> decodeJpeg(const PixelHeader& header, std::span<const std::byte> data) {
  jpeg_error_mgr errors = throwingErrors();
  jpeg_decompress_struct codec;
  codec.err = &errors;
  jpeg_create_decompress(&codec);
  const std::shared_ptr<void> release(nullptr, [&](void*) { jpeg_destroy_decompress(&codec); });
  jpeg_mem_src(&codec, reinterpret_cast<const unsigned char*>(data.data()), data.size());
  jpeg_read_header(&codec, TRUE);
  if (codec.image_width != header.w || codec.image_height != header.h)
    throw Error("JPEG data of a tile: " + std::to_string(codec.image_width) + " x " +
                std::to_string(codec.image_height) + " pixels, expected " + std::to_string(header.w) + " x " +
                std::to_string(header.h));
  codec.out_color_space = JCS_RGB;
  jpeg_start_decompress(&codec);
  std::vector<uint8_t> pixels(size_t(header.w) * header.h * 3);
  while (codec.output_scanline < codec.output_height) {
    JSAMPROW row = &pixels[size_t(codec.output_scanline) * header.w * 3];
    jpeg_read_scanlines(&codec, &row, 1);
  }
  jpeg_finish_decompress(&codec);
  return pixels;
}

Bytes encodeZlib(std::span<const std::byte> bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  Bytes out(size);
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                uLong(bytes.size()), kZlibLevel) != Z_OK)
    throw Error("zlib: a tile of " + std::to_string(bytes.size()) + " bytes cannot be compressed");
  out.resize(size);
  return out;
}

// These return the number of decoded bytes, which is at most the size of `pixels`.
size_t decodeZlib(std::span<const std::byte> data, std::span<uint8_t> pixels) {
  uLongf size = uLongf(pixels.size());
  const int status =
      uncompress(pixels.data(), &size, reinterpret_cast<const Bytef*>(data.data()), uLong(data.size()));
  if (status != Z_OK) throw Error("zlib data of a tile: they are broken, or too many");
  return size;
}
size_t decodeZstd(std::span<const std::byte> data, std::span<uint8_t> pixels) {
  const size_t size = ZSTD_decompress(pixels.data(), pixels.size(), data.data(), data.size());
  if (ZSTD_isError(size)) throw Error(std::string("zstd data of a tile: ") + ZSTD_getErrorName(size));
  return size;
}

}  // namespace

Bytes encodeTile(std::span<const uint8_t> rgba, uint32_t w, uint32_t h, PixelEncoding encoding, int quality) {
  if (encoding == PixelEncoding::Jpeg) return encodeJpeg(rgba, w, h, quality);
  const auto bytes = std::as_bytes(rgba);
  if (encoding == PixelEncoding::Raw) return Bytes(bytes.begin(), bytes.end());
  if (encoding == PixelEncoding::Zlib) return encodeZlib(bytes);
  Bytes out(ZSTD_compressBound(bytes.size()));
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
  if (ZSTD_isError(size)) throw Error(std::string("zstd: ") + ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

TilePixels decodeTile(const PixelHeader& header, std::span<const std::byte> data) {
  if (header.format != formatOf(header.encoding))
    throw Error("tile: format " + std::to_string(int(header.format)) + " with encoding " +
                std::to_string(int(header.encoding)) + ", expected RGB with JPEG and RGBA with the others");
  if (header.encoding == PixelEncoding::Jpeg) return {PixelFormat::Rgb8, decodeJpeg(header, data)};
  const size_t expected = size_t(header.w) * header.h * 4;
  TilePixels tile{PixelFormat::Rgba8, std::vector<uint8_t>(expected)};
  size_t size = data.size();
  if (header.encoding == PixelEncoding::Raw) {
    if (size == expected && expected) std::memcpy(tile.bytes.data(), data.data(), expected);
  } else {
    size =
        header.encoding == PixelEncoding::Zlib ? decodeZlib(data, tile.bytes) : decodeZstd(data, tile.bytes);
  }
  if (size != expected)
    throw Error("tile: " + std::to_string(size) + " bytes of pixels, expected " + std::to_string(expected));
  return tile;
}

}  // namespace gxy::protocol
