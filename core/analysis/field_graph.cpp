// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_graph.h"

#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace gxy {
namespace {

using Op = ExpressionOp;
using Kind = ValueType::Kind;

struct SameValue {
  bool operator()(const PointValue& a, const PointValue& b) const {
    return a.op == b.op && a.axis == b.axis && a.source == b.source && a.component == b.component &&
           std::bit_cast<uint64_t>(a.number) == std::bit_cast<uint64_t>(b.number) && a.operands == b.operands;
  }
};
struct HashOfValue {
  size_t operator()(const PointValue& v) const {
    uint64_t h = uint64_t(v.op) * 31 + uint64_t(v.axis);
    const auto mix = [&h](uint64_t x) {
      h = (h ^ (x + 0x9e3779b97f4a7c15ull)) * 0xbf58476d1ce4e5b9ull, h ^= h >> 29;
    };
    mix(uint64_t(v.source) << 32 | uint32_t(v.component));
    mix(std::bit_cast<uint64_t>(v.number));
    for (int i = 0; i < operandsOf(v.op); ++i) mix(uint64_t(uint32_t(v.operands[size_t(i)])));
    return size_t(h);
  }
};

class Builder {
 public:
  using Components = std::array<int32_t, 9>;

  Builder(const Expression& expression, std::span<const ValueType> types,
          std::span<const ExpressionInput> inputs, std::span<const double> numbers)
      : nodes_(expression.nodes()), types_(types), inputs_(inputs), numbers_(numbers) {
    for (const std::string& name : expression.names())
      for (size_t i = 0; i < inputs.size(); ++i)
        if (inputs[i].name == name) {
          sources_.push_back(int32_t(i));
          break;
        }
  }

  FieldGraph build(size_t root) {
    std::vector<bool> needed(root + 1);
    needed[root] = true;
    for (size_t i = root + 1; i-- > 0;)
      if (needed[i] && !isQuery(nodes_[i].op))
        for (const int32_t o : nodes_[i].operands)
          if (o >= 0) needed[size_t(o)] = true;
    made_.resize(root + 1);
    for (size_t i = 0; i <= root; ++i)
      if (needed[i]) made_[i] = make(i);
    const Components& result = made_[root];
    graph_.results.assign(result.begin(), result.begin() + types_[root].components());
    return std::move(graph_);
  }

 private:
  static bool isQuery(Op op) { return op >= Op::MinOf; }

  int32_t add(const PointValue& value) {
    const auto [at, isNew] = known_.try_emplace(value, int32_t(graph_.values.size()));
    if (isNew) graph_.values.push_back(value);
    return at->second;
  }

  int32_t number(double x) {
    PointValue value;
    value.number = x == x ? x : std::numeric_limits<double>::quiet_NaN();  // one NaN
    return add(value);
  }
  bool isNumber(int32_t v) const { return graph_.values[size_t(v)].op == PointOp::Number; }
  double numberOf(int32_t v) const { return graph_.values[size_t(v)].number; }

  int32_t apply(PointOp op, std::initializer_list<int32_t> operands) {
    PointValue value;
    value.op = op;
    std::copy(operands.begin(), operands.end(), value.operands.begin());
    bool folds = true;
    std::array<const double*, 9> pointers{};
    for (size_t i = 0; i < operands.size(); ++i) {
      folds = folds && isNumber(value.operands[i]);
      pointers[i] = &graph_.values[size_t(value.operands[i])].number;
    }
    if (!folds) return add(value);
    double result = 0;
    computePoints(op, std::span(pointers.data(), operands.size()), 0, &result, 1);
    return number(result);
  }

  int32_t load(int32_t source, int32_t component) {
    PointValue value;
    value.op = PointOp::Load;
    value.source = source;
    value.component = component;
    return add(value);
  }

  int32_t coordinate(int axis) {
    PointValue value;
    value.op = PointOp::Coordinate;
    value.axis = int8_t(axis);
    return add(value);
  }

  int32_t difference(PointOp op, int axis, int32_t of) {
    if (isNumber(of)) return number(numberOf(of) * 0);
    PointValue value;
    value.op = op;
    value.axis = int8_t(axis);
    value.operands[0] = of;
    return add(value);
  }
  int32_t d(int axis, int32_t of) { return difference(PointOp::Difference, axis, of); }

  int32_t power(int32_t base, int32_t exponent) {
    if (isNumber(exponent) && numberOf(exponent) == 2) return apply(PointOp::Multiply, {base, base});
    if (isNumber(exponent) && numberOf(exponent) == 0.5) return apply(PointOp::Sqrt, {base});
    if (isNumber(exponent) && numberOf(exponent) == -1) return apply(PointOp::Divide, {number(1), base});
    return apply(PointOp::Power, {base, exponent});
  }

  int32_t dot(const Components& a, const Components& b) {
    int32_t sum = apply(PointOp::Multiply, {a[0], b[0]});
    for (size_t i = 1; i < 3; ++i) sum = apply(PointOp::Add, {sum, apply(PointOp::Multiply, {a[i], b[i]})});
    return sum;
  }

  Components jacobian(const Components& u) {
    Components j;
    for (int i = 0; i < 9; ++i) j[size_t(i)] = d(i % 3, u[size_t(i / 3)]);
    return j;
  }

  template <class Each>
  Components each(size_t node, Each make) {
    Components made{};
    for (size_t c = 0; c < size_t(types_[node].components()); ++c) made[c] = make(c);
    return made;
  }

  Components make(size_t node) {
    const ExpressionNode& n = nodes_[node];
    const auto value = [&](int i) -> const Components& { return made_[size_t(n.operands[size_t(i)])]; };
    const auto type = [&](int i) { return types_[size_t(n.operands[size_t(i)])]; };
    const auto unary = [&](PointOp op) {
      return each(node, [&](size_t c) { return apply(op, {value(0)[c]}); });
    };
    const auto binary = [&](PointOp op) {
      return each(node, [&](size_t c) { return apply(op, {value(0)[c], value(1)[c]}); });
    };
    const auto one = [](int32_t v) { return Components{v}; };
    switch (n.op) {
      case Op::Number:
        return one(number(n.number));
      case Op::NoData:
        return one(number(NAN));
      case Op::Time:
      case Op::MinOf:
      case Op::MaxOf:
      case Op::MeanOf:
      case Op::SumOf:
      case Op::QuantileOf:
        return one(number(numbers_[node]));
      case Op::Input:
        return input(n);
      case Op::X:
      case Op::Y:
      case Op::Z:
        return one(coordinate(int(n.op) - int(Op::X)));
      case Op::Negate:
        return unary(PointOp::Negate);
      case Op::Add:
        return binary(PointOp::Add);
      case Op::Subtract:
        return binary(PointOp::Subtract);
      case Op::Multiply: {
        const bool scalarFirst = type(0).kind == Kind::Scalar, scalarLast = type(1).kind == Kind::Scalar;
        return each(node, [&](size_t c) {
          return apply(PointOp::Multiply, {value(0)[scalarFirst ? 0 : c], value(1)[scalarLast ? 0 : c]});
        });
      }
      case Op::Divide:
        return each(node, [&](size_t c) { return apply(PointOp::Divide, {value(0)[c], value(1)[0]}); });
      case Op::Power:
        return one(power(value(0)[0], value(1)[0]));
      case Op::Less:
        return binary(PointOp::Less);
      case Op::LessEqual:
        return binary(PointOp::LessEqual);
      case Op::Greater:
        return one(apply(PointOp::Less, {value(1)[0], value(0)[0]}));
      case Op::GreaterEqual:
        return one(apply(PointOp::LessEqual, {value(1)[0], value(0)[0]}));
      case Op::Equal:
        return binary(PointOp::Equal);
      case Op::NotEqual:
        return binary(PointOp::NotEqual);
      case Op::And:
        return binary(PointOp::And);
      case Op::Or:
        return binary(PointOp::Or);
      case Op::Not:
        return unary(PointOp::Not);
      case Op::If:
        return each(node, [&](size_t c) { return choose(value(0)[0], value(1)[c], value(2)[c]); });
      case Op::IsNoData: {
        int32_t any = apply(PointOp::IsNoData, {value(0)[0]});
        for (size_t c = 1; c < size_t(type(0).components()); ++c)
          any = apply(PointOp::Or, {any, apply(PointOp::IsNoData, {value(0)[c]})});
        return one(any);
      }
      case Op::Component:
        return component(n);
      case Op::List:
        return {value(0)[0], value(1)[0], value(2)[0]};
      case Op::Dot:
        return one(dot(value(0), value(1)));
      case Op::Cross:
        return cross(value(0), value(1));
      case Op::Mag:
        return one(mag(value(0)));
      case Op::Norm: {
        const int32_t length = mag(value(0));
        return each(node, [&](size_t c) { return apply(PointOp::Divide, {value(0)[c], length}); });
      }
      case Op::Grad:
        return each(node, [&](size_t c) { return d(int(c), value(0)[0]); });
      case Op::Curl: {
        const Components& u = value(0);
        return each(node, [&](size_t c) {
          const size_t a = (c + 1) % 3, b = (c + 2) % 3;
          return apply(PointOp::Subtract, {d(int(a), u[b]), d(int(b), u[a])});
        });
      }
      case Op::Div: {
        const Components& u = value(0);
        return one(apply(PointOp::Add, {apply(PointOp::Add, {d(0, u[0]), d(1, u[1])}), d(2, u[2])}));
      }
      case Op::Jacobian:
        return jacobian(value(0));
      case Op::Q:
        return one(ofTensor(PointOp::Q, type(0).kind == Kind::Tensor ? value(0) : jacobian(value(0))));
      case Op::Lambda2:
        return one(ofTensor(PointOp::Lambda2, type(0).kind == Kind::Tensor ? value(0) : jacobian(value(0))));
      case Op::Laplacian: {
        const int32_t f = value(0)[0];
        const auto second = [&](int axis) { return difference(PointOp::SecondDifference, axis, f); };
        return one(apply(PointOp::Add, {apply(PointOp::Add, {second(0), second(1)}), second(2)}));
      }
      case Op::Sqrt:
        return unary(PointOp::Sqrt);
      case Op::Exp:
        return unary(PointOp::Exp);
      case Op::Log:
        return unary(PointOp::Log);
      case Op::Sin:
        return unary(PointOp::Sin);
      case Op::Cos:
        return unary(PointOp::Cos);
      case Op::Tan:
        return unary(PointOp::Tan);
      case Op::Abs:
        return unary(PointOp::Abs);
      case Op::Floor:
        return unary(PointOp::Floor);
      case Op::Atan2:
        return binary(PointOp::Atan2);
      case Op::Min:
        return binary(PointOp::Min);
      case Op::Max:
        return binary(PointOp::Max);
      case Op::Clamp:
        break;
    }
    return one(apply(PointOp::Min, {apply(PointOp::Max, {value(0)[0], value(1)[0]}), value(2)[0]}));
  }

  Components input(const ExpressionNode& n) {
    Components made{};
    const int32_t source = sources_[size_t(n.index)];
    const int components = inputs_[size_t(source)].components;
    if (components == 1 || components == 3 || components == 9)
      for (int c = 0; c < components; ++c) made[size_t(c)] = load(source, c);
    return made;
  }

  Components component(const ExpressionNode& n) {
    const ExpressionNode& of = nodes_[size_t(n.operands[0])];
    if (of.op == Op::Input) return {load(sources_[size_t(of.index)], n.index)};
    return {made_[size_t(n.operands[0])][size_t(n.index)]};
  }

  int32_t choose(int32_t condition, int32_t a, int32_t b) {
    if (!isNumber(condition)) return apply(PointOp::If, {condition, a, b});
    const double c = numberOf(condition);
    return c != c ? number(c) : c != 0 ? a : b;
  }

  Components cross(const Components& a, const Components& b) {
    Components made{};
    for (size_t c = 0; c < 3; ++c) {
      const size_t i = (c + 1) % 3, j = (c + 2) % 3;
      made[c] = apply(PointOp::Subtract,
                      {apply(PointOp::Multiply, {a[i], b[j]}), apply(PointOp::Multiply, {a[j], b[i]})});
    }
    return made;
  }

  int32_t mag(const Components& v) { return apply(PointOp::Mag, {v[0], v[1], v[2]}); }

  int32_t ofTensor(PointOp op, const Components& t) {
    return apply(op, {t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8]});
  }

  const std::span<const ExpressionNode> nodes_;
  const std::span<const ValueType> types_;
  const std::span<const ExpressionInput> inputs_;
  const std::span<const double> numbers_;
  std::vector<int32_t> sources_;  ///< by name: which input
  std::vector<Components> made_;  ///< by node
  FieldGraph graph_;
  std::unordered_map<PointValue, int32_t, HashOfValue, SameValue> known_;
};

}  // namespace

FieldGraph graphOf(const Expression& expression, std::span<const ValueType> types,
                   std::span<const ExpressionInput> inputs, std::span<const double> numbers, size_t root) {
  return Builder(expression, types, inputs, numbers).build(root);
}

}  // namespace gxy
