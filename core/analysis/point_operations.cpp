// SPDX-License-Identifier: Apache-2.0
// Which kernel does an operation.
#include <algorithm>

#include "core/analysis/field_graph.h"
#include "elementary_rows_ispc.h"
#include "point_rows_ispc.h"

namespace gxy {
namespace {

using Unary = void (*)(const double*, double*, int32_t);
using Binary = void (*)(const double*, const double*, double*, int32_t);

Unary unaryOf(PointOp op) {
  switch (op) {
    case PointOp::Negate:
      return ispc::pointNegate;
    case PointOp::Abs:
      return ispc::pointAbs;
    case PointOp::Floor:
      return ispc::pointFloor;
    case PointOp::Sqrt:
      return ispc::pointSqrt;
    case PointOp::Not:
      return ispc::pointNot;
    case PointOp::IsNoData:
      return ispc::pointIsNoData;
    case PointOp::Exp:
      return ispc::pointExp;
    case PointOp::Log:
      return ispc::pointLog;
    case PointOp::Sin:
      return ispc::pointSin;
    case PointOp::Cos:
      return ispc::pointCos;
    case PointOp::Tan:
      return ispc::pointTan;
    default:
      return nullptr;
  }
}

/// The kernels of a binary operation: of two rows, of a row and a number, of a number and a row.
struct Binaries {
  Binary rows, behind, before;
};

Binaries binariesOf(PointOp op) {
  switch (op) {
    case PointOp::Add:
      return {ispc::pointAddRR, ispc::pointAddRN, ispc::pointAddNR};
    case PointOp::Subtract:
      return {ispc::pointSubtractRR, ispc::pointSubtractRN, ispc::pointSubtractNR};
    case PointOp::Multiply:
      return {ispc::pointMultiplyRR, ispc::pointMultiplyRN, ispc::pointMultiplyNR};
    case PointOp::Divide:
      return {ispc::pointDivideRR, ispc::pointDivideRN, ispc::pointDivideNR};
    case PointOp::Min:
      return {ispc::pointMinRR, ispc::pointMinRN, ispc::pointMinNR};
    case PointOp::Max:
      return {ispc::pointMaxRR, ispc::pointMaxRN, ispc::pointMaxNR};
    case PointOp::Less:
      return {ispc::pointLessRR, ispc::pointLessRN, ispc::pointLessNR};
    case PointOp::LessEqual:
      return {ispc::pointLessEqualRR, ispc::pointLessEqualRN, ispc::pointLessEqualNR};
    case PointOp::Equal:
      return {ispc::pointEqualRR, ispc::pointEqualRN, ispc::pointEqualNR};
    case PointOp::NotEqual:
      return {ispc::pointNotEqualRR, ispc::pointNotEqualRN, ispc::pointNotEqualNR};
    case PointOp::And:
      return {ispc::pointAndRR, ispc::pointAndRN, ispc::pointAndNR};
    case PointOp::Or:
      return {ispc::pointOrRR, ispc::pointOrRN, ispc::pointOrNR};
    case PointOp::Power:
      return {ispc::pointPower, nullptr, nullptr};
    case PointOp::Atan2:
      return {ispc::pointAtan2, nullptr, nullptr};
    default:
      return {};
  }
}

}  // namespace

int operandsOf(PointOp op) {
  switch (op) {
    case PointOp::Number:
    case PointOp::Load:
    case PointOp::Coordinate:
    case PointOp::Fill:
      return 0;
    case PointOp::If:
    case PointOp::Mag:
      return 3;
    case PointOp::Q:
    case PointOp::Lambda2:
      return 9;
    case PointOp::Difference:
    case PointOp::SecondDifference:
      return 1;
    default:
      return unaryOf(op) ? 1 : 2;
  }
}

bool takesNumbers(PointOp op) { return op >= PointOp::Add && op <= PointOp::If; }

int reachOf(PointOp op) { return op == PointOp::Difference ? 2 : op == PointOp::SecondDifference ? 3 : 0; }

void computePoints(PointOp op, std::span<const double* const> operands, unsigned numbers, double* to,
                   int points) {
  if (const Unary unary = unaryOf(op)) return unary(operands[0], to, points);
  const Binaries binaries = binariesOf(op);
  if (binaries.rows)
    return (numbers == 2   ? binaries.behind
            : numbers == 1 ? binaries.before
                           : binaries.rows)(operands[0], operands[1], to, points);
  if (op == PointOp::If)
    return ispc::pointIf(operands[0], operands[1], operands[2], !(numbers & 2), !(numbers & 4), to, points);
  if (op == PointOp::Mag) return ispc::pointMag(operands[0], operands[1], operands[2], to, points);
  if (op == PointOp::Q) return ispc::pointQ(operands.data(), to, points);
  if (op == PointOp::Lambda2) return ispc::pointLambda2(operands.data(), to, points);
}

}  // namespace gxy
