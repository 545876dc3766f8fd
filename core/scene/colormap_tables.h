// SPDX-License-Identifier: Apache-2.0
// The published tables of the shipped colour maps. Each has 256 colours of six hexadecimal digits (rrggbb).
#pragma once
#include <string_view>

namespace gxy {

extern const std::string_view kViridisTable;
extern const std::string_view kInfernoTable;
extern const std::string_view kTurboTable;

}  // namespace gxy
