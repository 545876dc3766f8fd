// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: a result or an Error, of each reader of meshes and of the check of legacy VTK files.
#include <cstdint>
#include <string>

#include "core/comm/error.h"
#include "core/io/legacy_vtk.h"
#include "core/io/obj_reader.h"
#include "core/io/off_reader.h"
#include "core/io/ply_reader.h"
#include "core/io/point_table.h"
#include "core/io/stl_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  const auto attempt = [](auto read) {
    try {
      read();
    } catch (const gxy::Error&) {
    }
  };
  gxy::Flaws flaws;
  attempt([&] { gxy::readPly(bytes, "input", flaws); });
  attempt([&] { gxy::readObj(bytes, "input", flaws); });
  attempt([&] { gxy::readOff(bytes, "input", flaws); });
  attempt([&] { gxy::readCsv(bytes, "input", flaws); });
  attempt([&] { gxy::readXyz(bytes, "input", flaws); });
  attempt([&] { gxy::readStl(bytes, "input", flaws); });
  attempt([&] { gxy::checkLegacyVtk(bytes, "input"); });
  return 0;
}
