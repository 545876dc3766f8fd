// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: an Error, or an expression whose operands stand before their operations, and passes that compute it, whose
// steps use the registers and windows that there are, and need no more ghost layers than there are.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/analysis/expression.h"
#include "core/analysis/field_graph.h"
#include "core/analysis/field_passes.h"
#include "core/comm/error.h"

namespace {

using namespace gxy;

void check(const PointPlace& place, const FieldPass& pass) {
  const bool isRegister = place.kind == PointPlace::Kind::Register,
             isWindow = place.kind == PointPlace::Kind::Window;
  if (isRegister && !(place.index >= 0 && place.index < pass.registers)) std::abort();
  if (isWindow && !(place.index >= 0 && place.index < int(pass.windows.size()))) std::abort();
}

void check(const FieldPass& pass) {
  for (const auto& halo : pass.windows)
    for (const int layers : halo)
      if (layers < 0 || layers > 4) std::abort();
  for (const FieldStage& stage : pass.stages) {
    for (const PointStep& step : stage.steps) {
      check(step.to, pass);
      for (const PointPlace& place : step.operands) check(place, pass);
      const int reach = reachOf(step.op);
      if (reach == 0) continue;
      if (step.operands[0].kind != PointPlace::Kind::Window) std::abort();
      const auto axis = size_t(step.axis);
      if (pass.windows[size_t(step.operands[0].index)][axis] < stage.halo[axis] + reach) std::abort();
    }
    for (const PointPlace& place : stage.results) check(place, pass);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::array inputs{ExpressionInput{"f", 1}, ExpressionInput{"u", 3}, ExpressionInput{"t", 9},
                                 ExpressionInput{"w", 2}};
  try {
    const Expression expression(std::string(reinterpret_cast<const char*>(data), size));
    const auto nodes = expression.nodes();
    if (nodes.empty()) std::abort();
    for (size_t i = 0; i < nodes.size(); ++i)
      for (const int32_t operand : nodes[i].operands)
        if (operand >= int32_t(i)) std::abort();
    const auto types = typesOf(expression, inputs);
    if (types.size() != nodes.size()) std::abort();
    const std::vector<double> numbers(nodes.size(), 0.5);
    const FieldGraph graph = graphOf(expression, types, inputs, numbers, nodes.size() - 1);
    if (int(graph.results.size()) != types.back().components()) std::abort();
    for (const FieldPass& pass : passesOf(graph, int(inputs.size()), 4)) check(pass);
  } catch (const Error&) {
  }
  return 0;
}
