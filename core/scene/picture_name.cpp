// SPDX-License-Identifier: Apache-2.0
#include "core/scene/picture_name.h"

#include <cctype>
#include <cstdio>

namespace gxy {
namespace {

std::string joined(const std::string& annotation) {
  const bool separates = !annotation.empty() && std::ispunct(static_cast<unsigned char>(annotation[0]));
  return annotation.empty() || separates ? annotation : "_" + annotation;
}

}  // namespace

std::string pictureName(const std::string& prefix, const State& state, size_t index) {
  const size_t n = state.visualizations.size();
  char number[24];
  std::snprintf(number, sizeof number, "_%05zu", index);
  return prefix + number + joined(state.visualizations[index % n].annotation) +
         joined(state.cameras[index / n % state.cameras.size()].annotation);
}

}  // namespace gxy
