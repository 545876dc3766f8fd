// SPDX-License-Identifier: Apache-2.0
// The names that the language of expressions defines. Used inside core/analysis only.
#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/analysis/expression.h"

namespace gxy {

/// A function of the language, and how many arguments it takes.
struct ExpressionFunction {
  std::string_view name;
  ExpressionOp op;
  int arguments;
};

inline constexpr std::array kExpressionFunctions{
    ExpressionFunction{"if", ExpressionOp::If, 3},
    ExpressionFunction{"nodata", ExpressionOp::IsNoData, 1},
    ExpressionFunction{"dot", ExpressionOp::Dot, 2},
    ExpressionFunction{"cross", ExpressionOp::Cross, 2},
    ExpressionFunction{"mag", ExpressionOp::Mag, 1},
    ExpressionFunction{"norm", ExpressionOp::Norm, 1},
    ExpressionFunction{"grad", ExpressionOp::Grad, 1},
    ExpressionFunction{"curl", ExpressionOp::Curl, 1},
    ExpressionFunction{"div", ExpressionOp::Div, 1},
    ExpressionFunction{"jacobian", ExpressionOp::Jacobian, 1},
    ExpressionFunction{"q", ExpressionOp::Q, 1},
    ExpressionFunction{"lambda2", ExpressionOp::Lambda2, 1},
    ExpressionFunction{"laplacian", ExpressionOp::Laplacian, 1},
    ExpressionFunction{"sqrt", ExpressionOp::Sqrt, 1},
    ExpressionFunction{"exp", ExpressionOp::Exp, 1},
    ExpressionFunction{"log", ExpressionOp::Log, 1},
    ExpressionFunction{"sin", ExpressionOp::Sin, 1},
    ExpressionFunction{"cos", ExpressionOp::Cos, 1},
    ExpressionFunction{"tan", ExpressionOp::Tan, 1},
    ExpressionFunction{"atan2", ExpressionOp::Atan2, 2},
    ExpressionFunction{"abs", ExpressionOp::Abs, 1},
    ExpressionFunction{"min", ExpressionOp::Min,
                       2},  // with one argument MinOf; more are folded from the left
    ExpressionFunction{"max", ExpressionOp::Max, 2},  // with one argument MaxOf
    ExpressionFunction{"floor", ExpressionOp::Floor, 1},
    ExpressionFunction{"clamp", ExpressionOp::Clamp, 3},
    ExpressionFunction{"mean", ExpressionOp::MeanOf, 1},
    ExpressionFunction{"sum", ExpressionOp::SumOf, 1},
    ExpressionFunction{"quantile", ExpressionOp::QuantileOf, 2},
};

/// A word that is a value by itself.
struct ExpressionWord {
  std::string_view name;
  ExpressionOp op;
};
inline constexpr std::array kExpressionWords{
    ExpressionWord{"x", ExpressionOp::X}, ExpressionWord{"y", ExpressionOp::Y},
    ExpressionWord{"z", ExpressionOp::Z}, ExpressionWord{"time", ExpressionOp::Time},
    ExpressionWord{"nodata", ExpressionOp::NoData}};

inline const ExpressionFunction* functionNamed(std::string_view name) {
  const auto found = std::ranges::find(kExpressionFunctions, name, &ExpressionFunction::name);
  return found == kExpressionFunctions.end() ? nullptr : &*found;
}
inline const ExpressionWord* wordNamed(std::string_view name) {
  const auto found = std::ranges::find(kExpressionWords, name, &ExpressionWord::name);
  return found == kExpressionWords.end() ? nullptr : &*found;
}

/// Whether a word is an operator.
inline bool isOperatorWord(std::string_view name) { return name == "and" || name == "or" || name == "not"; }

/// What the user writes for an operation: "curl()", "`+`".
inline std::string spelled(ExpressionOp op) {
  using Op = ExpressionOp;
  for (const ExpressionFunction& f : kExpressionFunctions)
    if (f.op == op) return std::string(f.name) + "()";
  switch (op) {
    case Op::MinOf:
      return "min()";
    case Op::MaxOf:
      return "max()";
    case Op::Negate:
      return "`-`";
    case Op::Add:
      return "`+`";
    case Op::Subtract:
      return "`-`";
    case Op::Multiply:
      return "`*`";
    case Op::Divide:
      return "`/`";
    case Op::Power:
      return "`^`";
    case Op::Less:
      return "`<`";
    case Op::LessEqual:
      return "`<=`";
    case Op::Greater:
      return "`>`";
    case Op::GreaterEqual:
      return "`>=`";
    case Op::Equal:
      return "`==`";
    case Op::NotEqual:
      return "`!=`";
    case Op::And:
      return "`and`";
    case Op::Or:
      return "`or`";
    case Op::Not:
      return "`not`";
    case Op::List:
      return "[a, b, c]";
    default:
      return "this";
  }
}

}  // namespace gxy
