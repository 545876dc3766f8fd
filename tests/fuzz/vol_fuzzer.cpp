// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: a result or an Error.
#include <cstdint>
#include <string_view>

#include "core/comm/error.h"
#include "core/io/volume_description.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    gxy::parseVol(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  } catch (const gxy::Error&) {
  }
  return 0;
}
