// SPDX-License-Identifier: Apache-2.0
// What evaluations of expressions have in common, whatever their fields are on. Used inside core/analysis only.
#pragma once
#include <cstddef>
#include <vector>

#include "core/analysis/evaluate.h"
#include "core/analysis/field_graph.h"
#include "core/analysis/statistics.h"

namespace gxy {

/// The evaluation of one expression on this rank. All ranks call the same collective functions.
class Evaluation {
 public:
  /// All must outlive it.
  Evaluation(const Expression& expression, Collectives& ranks, const DeriveOptions& options);
  virtual ~Evaluation() = default;
  Evaluation(const Evaluation&) = delete;
  Evaluation& operator=(const Evaluation&) = delete;

  ValueType type() const { return types_.back(); }
  size_t root() const { return types_.size() - 1; }
  double number() const { return numberAt(root()); }

  /// Throws Error unless the result is a field.
  void expectField(bool logical) const;
  /// Throws Error unless the result is one number.
  void expectNumber() const;
  /// Collective. Finds the numbers of `time` and of queries, in the order of the text.
  void findNumbers();

 protected:
  /// Finds the types of all operations. Throws Error as typesOf() does.
  void setInputs(std::vector<ExpressionInput> inputs);
  FieldGraph graphAt(size_t node) const { return graphOf(expression_, types_, typed_, numbers_, node); }
  /// Collective. Numbers of a component of the input with this name.
  virtual Statistics statisticsOfInput(const std::string& name, const StatisticsOptions& wanted) = 0;
  /// Collective. Numbers of what operation `node` computes.
  virtual Statistics statisticsOfNode(size_t node, const StatisticsOptions& wanted) = 0;

  const Expression& expression_;
  Collectives& ranks_;
  const DeriveOptions& options_;
  std::function<void(int64_t)> memory_ = [](int64_t) {};
  std::vector<ValueType> types_;

 private:
  double numberAt(size_t node) const;
  double query(const ExpressionNode& node);
  Statistics statisticsAt(size_t node, StatisticsOptions wanted);

  std::vector<ExpressionInput> typed_;
  std::vector<double> numbers_;  ///< of `time` and of queries, by node
};

}  // namespace gxy
