// SPDX-License-Identifier: Apache-2.0
// Types of operations, from the types of their operands.
#include <algorithm>
#include <optional>

#include "core/analysis/expression.h"
#include "core/analysis/expression_names.h"
#include "core/comm/error_text.h"
#include "core/scene/read_context.h"

namespace gxy {
namespace {

using Op = ExpressionOp;
using Kind = ValueType::Kind;

const char* kindName(Kind kind) {
  switch (kind) {
    case Kind::Scalar:
      return "scalar";
    case Kind::Vector:
      return "vector";
    case Kind::Tensor:
      return "tensor";
    case Kind::Logical:
      break;
  }
  return "logical value";
}

class Checker {
 public:
  Checker(const Expression& expression, std::span<const ExpressionInput> inputs)
      : expression_(expression), inputs_(inputs), nodes_(expression.nodes()) {}

  std::vector<ValueType> types() {
    const std::vector<std::string>& names = expression_.names();
    found_.assign(names.size(), nullptr);
    for (const ExpressionInput& input : inputs_)
      for (size_t i = 0; i < names.size(); ++i)
        if (names[i] == input.name) found_[i] = &input;
    // An input with other components than types have is left open until its component is taken.
    open_.assign(nodes_.size(), false);
    for (size_t i = 0; i < nodes_.size(); ++i) types_.push_back(typeOf(nodes_[i], i));
    refuseOpen(nodes_.size() - 1);
    return std::move(types_);
  }

 private:
  [[noreturn]] void fail(const ExpressionNode& node, const std::string& what) const {
    expression_.fail(node.position, what);
  }

  const ValueType& operand(const ExpressionNode& node, int i) const {
    return types_[size_t(node.operands[size_t(i)])];
  }
  bool has(const ExpressionNode& node, int i) const { return node.operands[size_t(i)] >= 0; }

  /// Whether all operands are numbers.
  bool numbers(const ExpressionNode& node) const {
    bool all = true;
    for (int i = 0; i < 3 && has(node, i); ++i) all = all && operand(node, i).number;
    return all;
  }

  void refuseOpen(size_t i) const {
    if (!open_[i]) return;
    const ExpressionInput& input = *found_[size_t(nodes_[i].index)];
    fail(nodes_[i], inQuotes(input.name, '`') + " has " + std::to_string(input.components) +
                        " components, expected 1 (a scalar), 3 (a vector) or 9 (a tensor), or one of its "
                        "components, as in " +
                        inQuotes(input.name + ".0", '`'));
  }

  void expect(const ExpressionNode& node, int i, Kind kind) const {
    if (operand(node, i).kind != kind)
      fail(node, spelled(node.op) + " of a " + nameOf(operand(node, i)) + ", expected a " + kindName(kind));
  }
  void expectField(const ExpressionNode& node) const {
    if (operand(node, 0).number)
      fail(node, spelled(node.op) + " of a number, which is the same at all points, expected a field");
  }

  ValueType ofScalars(const ExpressionNode& node, Kind kind) const {
    for (int i = 0; i < 3 && has(node, i); ++i) expect(node, i, Kind::Scalar);
    return {kind, numbers(node)};
  }
  ValueType ofLogicals(const ExpressionNode& node) const {
    for (int i = 0; i < 3 && has(node, i); ++i) expect(node, i, Kind::Logical);
    return {Kind::Logical, numbers(node)};
  }
  ValueType ofVectors(const ExpressionNode& node, Kind kind) const {
    for (int i = 0; i < 3 && has(node, i); ++i) expect(node, i, Kind::Vector);
    return {kind, numbers(node)};
  }
  ValueType differential(const ExpressionNode& node, Kind of, Kind result) const {
    expect(node, 0, of);
    expectField(node);
    return {result, false};
  }

  ValueType typeOf(const ExpressionNode& node, size_t at) {
    if (node.op == Op::Input) return input(node, at);
    if (node.op == Op::Component) return component(node);
    for (int i = 0; i < 3 && has(node, i); ++i) refuseOpen(size_t(node.operands[size_t(i)]));
    switch (node.op) {
      case Op::Number:
      case Op::Time:
      case Op::NoData:
        return {Kind::Scalar, true};
      case Op::X:
      case Op::Y:
      case Op::Z:
        return {Kind::Scalar, false};
      case Op::Negate:
        if (operand(node, 0).kind == Kind::Logical) fail(node, "`-` of a logical value, expected `not`");
        return operand(node, 0);
      case Op::Add:
      case Op::Subtract:
        return sum(node);
      case Op::Multiply:
        return product(node);
      case Op::Divide:
        return quotient(node);
      case Op::Equal:
      case Op::NotEqual:
        if (operand(node, 0).kind == Kind::Logical && operand(node, 1).kind == Kind::Logical)
          return ofLogicals(node);
        return ofScalars(node, Kind::Logical);
      case Op::Less:
      case Op::LessEqual:
      case Op::Greater:
      case Op::GreaterEqual:
        return ofScalars(node, Kind::Logical);
      case Op::And:
      case Op::Or:
      case Op::Not:
        return ofLogicals(node);
      case Op::If:
        return choice(node);
      case Op::IsNoData:
        return {Kind::Logical, operand(node, 0).number};
      case Op::List:
        return ofScalars(node, Kind::Vector);
      case Op::Dot:
      case Op::Mag:
        return ofVectors(node, Kind::Scalar);
      case Op::Cross:
      case Op::Norm:
        return ofVectors(node, Kind::Vector);
      case Op::Grad:
        if (operand(node, 0).kind == Kind::Vector)
          fail(node, "grad() of a vector, expected a scalar; jacobian() is that of a vector");
        return differential(node, Kind::Scalar, Kind::Vector);
      case Op::Curl:
        return differential(node, Kind::Vector, Kind::Vector);
      case Op::Div:
        return differential(node, Kind::Vector, Kind::Scalar);
      case Op::Jacobian:
        return differential(node, Kind::Vector, Kind::Tensor);
      case Op::Q:
      case Op::Lambda2:
        if (operand(node, 0).kind == Kind::Tensor) return {Kind::Scalar, operand(node, 0).number};
        return differential(node, Kind::Vector, Kind::Scalar);
      case Op::Laplacian:
        return differential(node, Kind::Scalar, Kind::Scalar);
      case Op::MinOf:
      case Op::MaxOf:
      case Op::MeanOf:
      case Op::SumOf:
        return number(node);
      case Op::QuantileOf:
        expect(node, 1, Kind::Scalar);
        if (!operand(node, 1).number)
          fail(node, "the second argument of quantile() is a field, expected a number from 0 to 1");
        return number(node);
      default:
        return ofScalars(node, Kind::Scalar);
    }
  }

  ValueType input(const ExpressionNode& node, size_t at) {
    const ExpressionInput* input = found_[size_t(node.index)];
    if (!input) failUnknown(node);
    open_[at] = input->components != 1 && input->components != 3 && input->components != 9;
    return {input->components == 3   ? Kind::Vector
            : input->components == 9 ? Kind::Tensor
                                     : Kind::Scalar,
            false};
  }

  [[noreturn]] void failUnknown(const ExpressionNode& node) const {
    const std::string& name = expression_.names()[size_t(node.index)];
    if (functionNamed(name)) fail(node, inQuotes(name, '`') + " is a function, expected `(` behind it");
    std::vector<std::string> names;
    std::string list;
    for (const ExpressionInput& input : inputs_) {
      names.push_back(input.name);
      if (names.size() <= 10) list += (list.empty() ? "" : ", ") + inQuotes(input.name, '`');
    }
    if (names.size() > 10) list += ", ...";
    const std::string expected = list.empty() ? "there are no inputs" : "expected one of the inputs " + list;
    for (const ExpressionWord& word : kExpressionWords)
      if (word.name.size() > 1) names.emplace_back(word.name);
    fail(node, "unknown name " + inQuotes(name, '`') + ", " + expected +
                   (name.size() > 1 ? suggestion(name, names) : ""));
  }

  ValueType component(const ExpressionNode& node) const {
    const auto of = size_t(node.operands[0]);
    const bool isInput = nodes_[of].op == Op::Input;
    const ValueType type = types_[of];
    const int components = isInput ? found_[size_t(nodes_[of].index)]->components : type.components();
    if (!isInput && type.kind != Kind::Vector && type.kind != Kind::Tensor)
      fail(node, "a component of a " + nameOf(type) + ", expected a vector");
    if (node.index >= components)
      fail(node, "component " + std::to_string(node.index) + " of " + std::to_string(components) +
                     ", expected 0 to " + std::to_string(components - 1));
    return {Kind::Scalar, type.number};
  }

  ValueType sum(const ExpressionNode& node) const {
    const ValueType a = operand(node, 0), b = operand(node, 1);
    if (a.kind != b.kind || a.kind == Kind::Logical)
      fail(node, spelled(node.op) + " of a " + nameOf(a) + " and a " + nameOf(b) +
                     ", expected two of the same type" +
                     (a.kind == Kind::Logical || b.kind == Kind::Logical ? " that are not logical" : ""));
    return {a.kind, numbers(node)};
  }

  ValueType product(const ExpressionNode& node) const {
    const ValueType a = operand(node, 0), b = operand(node, 1);
    if (a.kind == Kind::Logical || b.kind == Kind::Logical)
      fail(node, "`*` of a " + nameOf(a) + " and a " + nameOf(b) + ", expected `and`, or if(c, a, b)");
    if (a.kind != Kind::Scalar && b.kind != Kind::Scalar)
      fail(node, "`*` of a " + nameOf(a) + " and a " + nameOf(b) +
                     ", expected a scalar in one place; dot() and cross() are those of vectors");
    return {a.kind == Kind::Scalar ? b.kind : a.kind, numbers(node)};
  }

  ValueType quotient(const ExpressionNode& node) const {
    expect(node, 1, Kind::Scalar);
    if (operand(node, 0).kind == Kind::Logical)
      fail(node, "`/` of a logical value, expected a scalar, a vector or a tensor");
    return {operand(node, 0).kind, numbers(node)};
  }

  ValueType choice(const ExpressionNode& node) const {
    if (operand(node, 0).kind != Kind::Logical)
      fail(node, "the condition of if() is a " + nameOf(operand(node, 0)) +
                     ", expected a logical value, such as a comparison");
    const ValueType a = operand(node, 1), b = operand(node, 2);
    if (a.kind != b.kind)
      fail(node,
           "if() chooses between a " + nameOf(a) + " and a " + nameOf(b) + ", expected two of the same type");
    return {a.kind, numbers(node)};
  }

  ValueType number(const ExpressionNode& node) const {
    expect(node, 0, Kind::Scalar);
    expectField(node);
    return {Kind::Scalar, true};
  }

  const Expression& expression_;
  const std::span<const ExpressionInput> inputs_;
  const std::span<const ExpressionNode> nodes_;
  std::vector<const ExpressionInput*> found_;  ///< by name
  std::vector<bool> open_;                     ///< by node
  std::vector<ValueType> types_;
};

}  // namespace

std::string nameOf(ValueType type) {
  if (!type.number)
    return type.kind == Kind::Logical ? "logical field" : std::string(kindName(type.kind)) + " field";
  return type.kind == Kind::Scalar    ? "number"
         : type.kind == Kind::Logical ? "logical number"
                                      : kindName(type.kind);
}

std::vector<ValueType> typesOf(const Expression& expression, std::span<const ExpressionInput> inputs) {
  return Checker(expression, inputs).types();
}

}  // namespace gxy
