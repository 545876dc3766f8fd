// SPDX-License-Identifier: Apache-2.0
// Headers of images with raw samples. Whatever the bytes, each reader of them gives a result or an Error.
#include <cstdint>
#include <string_view>

#include "core/comm/error.h"
#include "core/io/image_header.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const auto parse : {gxy::parseMetaImage, gxy::parseNrrd, gxy::parseNifti, gxy::parseNpy}) {
    try {
      parse(bytes, "input");
    } catch (const gxy::Error&) {
    }
  }
  return 0;
}
