// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: an Error, or an expression whose operands stand before their operations, with or without types.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/analysis/expression.h"
#include "core/comm/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gxy;
  static const std::array inputs{ExpressionInput{"f", 1}, ExpressionInput{"u", 3}, ExpressionInput{"t", 9},
                                 ExpressionInput{"w", 2}};
  try {
    const Expression expression(std::string(reinterpret_cast<const char*>(data), size));
    const auto nodes = expression.nodes();
    if (nodes.empty()) std::abort();
    for (size_t i = 0; i < nodes.size(); ++i)
      for (const int32_t operand : nodes[i].operands)
        if (operand >= int32_t(i)) std::abort();
    if (typesOf(expression, inputs).size() != nodes.size()) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
