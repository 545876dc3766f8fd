// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "core/scene/scene.h"

namespace gxy {

const char* nameOf(OutputSpec::Type type) {
  constexpr const char* kNames[] = {"Data file", "Pictures", "Publish"};
  return kNames[size_t(type)];
}

std::string fileOfStep(const std::string& to, int64_t step) {
  constexpr std::string_view kStep = "{step}";
  char number[24];
  std::snprintf(number, sizeof number, "%06lld", static_cast<long long>(step));
  std::string file = to;
  for (size_t at = file.find(kStep); at != file.npos; at = file.find(kStep, at + 1))
    file.replace(at, kStep.size(), number);
  return file;
}

}  // namespace gxy
