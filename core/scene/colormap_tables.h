// SPDX-License-Identifier: Apache-2.0
// The published tables behind the shipped colour maps: 256 colours each, six hexadecimal digits (rrggbb) a
// colour.
#pragma once
#include <string_view>

namespace gxy {

extern const std::string_view kViridisTable;
extern const std::string_view kInfernoTable;
extern const std::string_view kTurboTable;

}  // namespace gxy
