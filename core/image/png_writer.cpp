// SPDX-License-Identifier: Apache-2.0
#include "core/image/png_writer.h"

#include <png.h>

#include <csetjmp>
#include <new>
#include <string>

#include "core/comm/error.h"

namespace gxy {
namespace {

struct Output {
  std::vector<std::byte> bytes;
  std::string error;
};

void append(png_structp png, png_bytep data, size_t size) {
  auto& out = *static_cast<Output*>(png_get_io_ptr(png));
  bool whole = true;
  try {
    const auto* from = reinterpret_cast<const std::byte*>(data);
    out.bytes.insert(out.bytes.end(), from, from + size);
  } catch (const std::bad_alloc&) {
    whole = false;  // No exception may pass through libpng.
  }
  if (!whole) png_error(png, "out of memory");
}

[[noreturn]] void fail(png_structp png, png_const_charp message) {
  static_cast<Output*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

struct Writer {
  png_structp png;
  png_infop info = nullptr;
  explicit Writer(Output& out) : png(png_create_write_struct(PNG_LIBPNG_VER_STRING, &out, fail, ignore)) {
    if (png) info = png_create_info_struct(png);
    if (info) return;
    png_destroy_write_struct(&png, &info);
    throw Error(
        "libpng cannot be used: there is no memory, or it is of another version than Galaxy was built with");
  }
  ~Writer() { png_destroy_write_struct(&png, &info); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
};

/// Returns false if libpng failed. This function has no local objects with destructors, because longjmp
/// would not call them.
bool write(png_structp png, png_infop info, const uint8_t* levels, size_t width, size_t height) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), 8, PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (size_t y = height; y-- > 0;) png_write_row(png, levels + 4 * width * y);  // top row first
  png_write_end(png, info);
  return true;
}

}  // namespace

std::vector<std::byte> encodePng(const Image& image) {
  const std::vector<uint8_t> levels = eightBits(image.rgba);
  Output out;
  const Writer writer(out);
  png_set_write_fn(writer.png, &out, append, nullptr);
  if (!write(writer.png, writer.info, levels.data(), size_t(image.width), size_t(image.height)))
    throw Error("libpng: " + out.error);
  return std::move(out.bytes);
}

}  // namespace gxy
