// SPDX-License-Identifier: Apache-2.0
// The language of derived fields: from text to a checked tree of operations. evaluate.h computes with it.
//
//   numbers        1, 0.5, 2e-3; `time` is the time of the inputs; `nodata` is a value that does not exist
//   names          of inputs; `x`, `y` and `z` are world coordinates
//   + - * / ^      ^ is right associative and binds tighter than a minus before it: -x^2 is -(x^2)
//   < <= > >= == !=  and  or  not      of scalars, and of what is true or false (logical)
//   if(c, a, b)    a where c holds, else b
//   nodata(f)      whether f has no data
//   u.x u.y u.z    components of a vector; u.0, u.1, ... of an input with any number of components
//   [a, b, c]      a vector
//   dot cross      of two vectors; mag is the length of a vector, and norm is the vector divided by it
//   grad laplacian of a scalar; curl div jacobian of a vector; per world unit
//   q lambda2      of a vector, or of its jacobian
//   sqrt exp log sin cos tan floor abs atan2(y, x) clamp(f, lo, hi)     log is the natural logarithm
//   min max        with two or more arguments: of each point. With one argument: a number, of the whole field
//   mean sum quantile(f, 0.9)                                           numbers, of the whole field
//
// Operators bind in this order, from the tightest: `.`, ^, minus and plus before a value, * /, + -, comparisons, not, and, or.
// There are these types: scalar, vector (3 components), tensor (9 components, d u_i / d x_j at 3 i + j) and logical, and each of
// them is a field or a number. A number is the same at all points. `and`, `or` and `not` are those of three-valued logic
// (Kleene): where an operand has no data the result has none, unless the other operand decides it.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

enum class ExpressionOp : uint8_t {
  Number,
  Input,
  X,
  Y,
  Z,
  Time,
  NoData,  // values
  Negate,
  Add,
  Subtract,
  Multiply,
  Divide,
  Power,  // arithmetic
  Less,
  LessEqual,
  Greater,
  GreaterEqual,
  Equal,
  NotEqual,  // comparisons
  And,
  Or,
  Not,
  If,
  IsNoData,  // logic
  Component,
  List,
  Dot,
  Cross,
  Mag,
  Norm,  // vectors
  Grad,
  Curl,
  Div,
  Jacobian,
  Q,
  Lambda2,
  Laplacian,  // differentials
  Sqrt,
  Exp,
  Log,
  Sin,
  Cos,
  Tan,
  Atan2,
  Abs,
  Min,
  Max,
  Floor,
  Clamp,  // functions of each point
  MinOf,
  MaxOf,
  MeanOf,
  SumOf,
  QuantileOf  // numbers of whole fields
};

/// What a value is. `number` says that it is the same at all points.
struct ValueType {
  enum class Kind : uint8_t { Scalar, Vector, Tensor, Logical };
  Kind kind = Kind::Scalar;
  bool number = false;
  int components() const { return kind == Kind::Vector ? 3 : kind == Kind::Tensor ? 9 : 1; }
  bool operator==(const ValueType&) const = default;
};

/// An operation of an expression. Its operands are operations that stand before it.
struct ExpressionNode {
  ExpressionOp op = ExpressionOp::Number;
  uint32_t position = 0;  ///< byte of the text
  std::array<int32_t, 3> operands{-1, -1, -1};
  double number = 0;   ///< of a Number
  int32_t index = -1;  ///< of an Input: in names(); of a Component: which
};

/// A text that has been parsed. It is immutable; any thread may read it.
class Expression {
 public:
  static constexpr size_t kMostBytes = 64 << 10;  ///< of the text
  static constexpr int kMostDepth = 64;  ///< of parentheses, calls, lists, signs and powers inside each other

  /// Throws Error with line and column, what is wrong there and what was expected. It takes time in proportion to the text.
  explicit Expression(std::string text);

  const std::string& text() const { return text_; }
  /// The names of inputs, in the order of their first use.
  const std::vector<std::string>& names() const { return names_; }
  /// All operations; the last one is the result.
  std::span<const ExpressionNode> nodes() const { return nodes_; }

  /// Throws Error about what stands at a byte of the text.
  [[noreturn]] void fail(size_t position, const std::string& what) const;

 private:
  friend class ExpressionParser;
  std::string text_;
  std::vector<std::string> names_;
  std::vector<ExpressionNode> nodes_;
};

/// An input as the types depend on it: 1 component is a scalar, 3 are a vector, 9 are a tensor.
struct ExpressionInput {
  std::string name;
  int components = 1;
};

/// Returns the type of each operation. Throws Error with line and column for a name that is no input, and for operands of wrong
/// types. Inputs may have other numbers of components than 1, 3 and 9 if only their components are used.
std::vector<ValueType> typesOf(const Expression& expression, std::span<const ExpressionInput> inputs);

/// Returns "scalar field", "vector", "number" and so on, for messages.
std::string nameOf(ValueType type);

}  // namespace gxy
