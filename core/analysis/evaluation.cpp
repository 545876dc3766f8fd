// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/evaluation.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

Evaluation::Evaluation(const Expression& expression, Collectives& ranks, const DeriveOptions& options)
    : expression_(expression), ranks_(ranks), options_(options) {
  if (options_.memory) memory_ = options_.memory;
}

void Evaluation::setInputs(std::vector<ExpressionInput> inputs) {
  typed_ = std::move(inputs);
  types_ = typesOf(expression_, typed_);
  numbers_.assign(types_.size(), std::numeric_limits<double>::quiet_NaN());
}

void Evaluation::expectField(bool logical) const {
  if (type().number)
    throw Error("expression: the result is a " + nameOf(type()) +
                ", which is the same at all points, expected a field");
  if (logical && type().kind != ValueType::Kind::Logical)
    throw Error("expression: the result is a " + nameOf(type()) +
                ", expected a condition, such as a comparison");
}

void Evaluation::expectNumber() const {
  if (!type().number || type().components() != 1)
    throw Error("expression: the result is a " + nameOf(type()) + ", expected a number, such as max(f)");
}

void Evaluation::findNumbers() {
  const auto nodes = expression_.nodes();
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].op == ExpressionOp::Time)
      agree(ranks_, [&] {
        if (std::isnan(options_.time))
          expression_.fail(nodes[i].position, "the time of the inputs is not known");
        numbers_[i] = options_.time;
      });
    if (nodes[i].op >= ExpressionOp::MinOf) numbers_[i] = query(nodes[i]);
  }
}

double Evaluation::numberAt(size_t node) const {
  const FieldGraph graph = graphAt(node);
  return graph.values[size_t(graph.results[0])].number;
}

double Evaluation::query(const ExpressionNode& node) {
  StatisticsOptions wanted;
  agree(ranks_, [&] {
    if (node.op != ExpressionOp::QuantileOf) return;
    const double fraction = numberAt(size_t(node.operands[1]));
    if (!(fraction >= 0 && fraction <= 1))
      expression_.fail(node.position,
                       "quantile() at " + std::to_string(fraction) + ", expected a number from 0 to 1");
    wanted.quantiles = {fraction};
  });
  const Statistics found = statisticsAt(size_t(node.operands[0]), wanted);
  if (found.count == 0) return std::numeric_limits<double>::quiet_NaN();
  switch (node.op) {
    case ExpressionOp::MinOf:
      return found.least.value;
    case ExpressionOp::MaxOf:
      return found.largest.value;
    case ExpressionOp::MeanOf:
      return found.mean;
    case ExpressionOp::SumOf:
      return found.sum;
    default:
      return found.quantiles[0];
  }
}

// Of the samples of an input, if the operation is one or a component of one.
Statistics Evaluation::statisticsAt(size_t node, StatisticsOptions wanted) {
  const auto nodes = expression_.nodes();
  const ExpressionNode& n = nodes[node];
  const bool isComponent =
      n.op == ExpressionOp::Component && nodes[size_t(n.operands[0])].op == ExpressionOp::Input;
  if (n.op != ExpressionOp::Input && !isComponent) return statisticsOfNode(node, wanted);
  const int32_t which = isComponent ? nodes[size_t(n.operands[0])].index : n.index;
  wanted.component = isComponent ? n.index : 0;
  return statisticsOfInput(expression_.names()[size_t(which)], wanted);
}

}  // namespace gxy
