// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: any bytes give a StateFile that saves and loads to an equal State, or gxy::Error; also as
// a ParaView camera file and colour preset.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/comm/error.h"
#include "core/scene/colormaps.h"
#include "core/scene/paraview_camera.h"
#include "core/scene/state_file.h"

namespace {

template <class Parse>
void errorOrNothing(Parse parse) {
  try {
    parse();
  } catch (const gxy::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  errorOrNothing([&] {
    const gxy::StateFile file = gxy::readState(text, "input", "/nowhere");
    if (!(gxy::readState(gxy::writeState(file.state), "saved").state == file.state)) std::abort();
  });
  errorOrNothing([&] { gxy::parseParaViewCamera(text, "input"); });
  errorOrNothing([&] { gxy::parseColorPreset(gxy::parseJson(text, "input"), "input"); });
  return 0;
}
