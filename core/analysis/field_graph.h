// SPDX-License-Identifier: Apache-2.0
// An expression as operations on scalars at each point, each made once. Used inside core/analysis only.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/analysis/expression.h"

namespace gxy {

enum class PointOp : uint8_t {
  Number,
  Load,
  Coordinate,
  Difference,
  SecondDifference,  // leaves, and what needs neighbours
  Add,
  Subtract,
  Multiply,
  Divide,
  Min,
  Max,
  Less,
  LessEqual,
  Equal,
  NotEqual,
  And,
  Or,  // take numbers or rows
  If,
  Negate,
  Abs,
  Floor,
  Sqrt,
  Not,
  IsNoData,
  Exp,
  Log,
  Sin,
  Cos,
  Tan,
  Power,
  Atan2,
  Mag,
  Q,
  Lambda2,
  Fill
};

/// The number of operands of an operation.
int operandsOf(PointOp op);
/// Whether operands of an operation may be numbers, without a row of them.
bool takesNumbers(PointOp op);
/// How many points on each side of a point an operation needs along its axis.
int reachOf(PointOp op);

/// Computes an operation, but a leaf or a difference, for a row of points. Where `numbers` has bit i, operand i is one number.
void computePoints(PointOp op, std::span<const double* const> operands, unsigned numbers, double* to,
                   int points);

/// A scalar at each point. Operands are values that stand before it.
struct PointValue {
  PointOp op = PointOp::Number;
  int8_t axis = 0;        ///< of a Coordinate or a difference
  int32_t source = 0;     ///< of a Load: which field
  int32_t component = 0;  ///< of a Load
  double number = 0;      ///< of a Number
  std::array<int32_t, 9> operands{-1, -1, -1, -1, -1, -1, -1, -1, -1};
};

struct FieldGraph {
  std::vector<PointValue> values;
  std::vector<int32_t> results;  ///< by component
};

/// Returns the graph of operation `root` of an expression. `numbers` has the values of queries and of `time`, by node. Input i of
/// `inputs` is source i. What is computed of numbers alone is computed here.
FieldGraph graphOf(const Expression& expression, std::span<const ValueType> types,
                   std::span<const ExpressionInput> inputs, std::span<const double> numbers, size_t root);

}  // namespace gxy
