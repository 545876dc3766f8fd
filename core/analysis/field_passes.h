// SPDX-License-Identifier: Apache-2.0
// How a graph of values is computed: in passes over the grid, which are pipelines of stages. Used inside core/analysis only.
//
// A value whose difference is taken is a *window*: its rows around the current one are kept. Windows that reach equally far make
// a stage, and the results of a pass are its last stage. A stage computes its rows by *steps* on registers. A stage with halo h
// runs h planes ahead of the results, and over h more points on each side.
//
// Blocks have a limited number of ghost layers. A value that would need more is *stored*: an earlier pass makes a field of it,
// whose ghosts are exchanged, and later passes load it.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/analysis/field_graph.h"

namespace gxy {

/// Where a step finds an operand, or puts its result.
struct PointPlace {
  enum class Kind : uint8_t { None, Register, Window, Number } kind = Kind::None;
  int32_t index = -1;  ///< of a register or a window
  double number = 0;
};

struct PointStep {
  PointOp op = PointOp::Fill;
  int8_t axis = 0;
  int32_t source = 0, component = 0;  ///< of a Load
  std::array<PointPlace, 9> operands;
  PointPlace to;
};

struct FieldStage {
  std::array<int, 3> halo{0, 0, 0};
  std::vector<int32_t> windows;  ///< those that it fills
  std::vector<PointStep> steps;
  std::vector<PointPlace> results;  ///< of the last stage, by component: registers or windows
};

struct FieldPass {
  std::vector<FieldStage> stages;           ///< in order of computation
  std::vector<std::array<int, 3>> windows;  ///< the halo of each window
  int registers = 0;                        ///< the most that a stage needs
  std::vector<int32_t> sources;             ///< the fields that it loads
};

/// Returns the passes for blocks with so many ghost layers. The last one computes the results. Field `inputs` + i is that which
/// pass i stores. Throws Error if a stage needs more than kMostRegisters.
inline constexpr int kMostRegisters = 1024;
std::vector<FieldPass> passesOf(const FieldGraph& graph, int inputs, int ghosts);

}  // namespace gxy
