// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: any bytes give a sweep, whose pictures can be made of a state, or gxy::Error; and a table that is written and read
// as it was, or gxy::Error, and is a problem just if it is an Error.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/comm/error.h"
#include "core/scene/cinema_page.h"
#include "core/scene/cinema_table.h"
#include "core/scene/swept_pictures.h"

namespace {

void readAsSweep(std::string_view text) {
  const gxy::Sweep sweep = gxy::readSweep(text, "input");
  static const gxy::State state =
      gxy::readState(R"({"Datasets": {"name": "d", "type": "Volume", "filename": "d.vti"},
        "Visualization": {"operators": [{"type": "Volume", "dataset": "d", "isovalues": [0.5], "slices": [[1, 0, 0, 0]],
                                         "clip planes": [[0, 0, 1, 0]]}]},
        "Camera": {"viewpoint": [0, 0, 4], "viewcenter": [0, 0, 0]}})",
                     "state")
          .state;
  constexpr size_t kFew = 20;  // or it takes long
  const size_t count = gxy::countOfPictures(sweep, state);
  if (count > kFew || gxy::countOfScenes(sweep) > kFew) return;
  const gxy::SweptPictures swept = gxy::sweptPictures(
      sweep, state, [](const std::string& t) { return gxy::readState(t, "state", "/nowhere"); });
  if (swept.pictures.size() != count) std::abort();
  for (size_t p = 0; p < count; p++) gxy::cinemaFileName(swept.parametersOf(p, "1.0"), swept.time);
}

void readAsTable(std::string_view text) {
  std::vector<gxy::TableProblem> problems;
  const std::vector<gxy::CsvRecord> records = gxy::readCsv(text, problems);
  const bool valid = problems.empty() && gxy::problemsOfTable(records).empty();
  try {
    const gxy::CinemaTable table = gxy::CinemaTable::read(text, "input");
    if (!valid || gxy::CinemaTable::read(table.text(), "again").rows() != table.rows()) std::abort();
    gxy::cinemaPage(table, "input");
  } catch (const gxy::Error&) {
    if (valid) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    readAsSweep(text);
  } catch (const gxy::Error&) {
  }
  readAsTable(text);
  return 0;
}
