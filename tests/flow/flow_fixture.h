// SPDX-License-Identifier: Apache-2.0
// A Flow whose host does at once what it is asked for, but for evaluations.
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/flow/flow.h"
#include "tests/flow/filters.h"

namespace gxy::flow {

using test::live;
using test::made;
using State = NodeState::Kind;

inline std::string by(int amount) { return R"({"by":)" + std::to_string(amount) + "}"; }
inline DatasetSpec shift(const std::string& name, const std::string& of, int amount = 1) {
  return made(name, "Shift", {{"field", {of}}}, by(amount));
}
inline DatasetSpec sum(const std::string& name, const std::vector<std::string>& of) {
  return made(name, "Add", {{"fields", of}});
}
inline SourceData data(uint64_t object, Generation generation, std::vector<Origin> origins = {}) {
  return {{{object}, generation}, DatasetType::Volume, std::move(origins)};
}
/// A step of publisher 7.
inline SourceData step(uint64_t object, Generation generation, int64_t number) {
  return data(object, generation, {{7, number}});
}

class FlowTest : public testing::Test {
 protected:
  template <class A>
  std::vector<A> taken() {
    all_ = flow_.take();
    std::vector<A> out;
    for (const Action& action : all_)
      if (const auto* found = std::get_if<A>(&action)) out.push_back(*found);
    return out;
  }
  template <class A>
  std::vector<A> among() const {
    std::vector<A> out;
    for (const Action& action : all_)
      if (const auto* found = std::get_if<A>(&action)) out.push_back(*found);
    return out;
  }
  /// The nodes whose evaluation begins.
  std::vector<std::string> started() {
    std::vector<std::string> names;
    for (const StartEvaluation& start : taken<StartEvaluation>()) {
      names.push_back(start.node);
      numbers_[start.node] = start.evaluation;
    }
    return names;
  }
  void finish(const std::string& node) { flow_.finished(numbers_.at(node), {1, 0.5, 100}); }
  NodeState state(const std::string& node) { return flow_.state({NodeId::Kind::Dataset, node}); }
  NodeState viewState(const std::string& view) { return flow_.state({NodeId::Kind::View, view}); }
  /// Evaluates all that is asked for.
  void finishAll() {
    for (std::vector<std::string> names = started(); !names.empty(); names = started())
      for (const std::string& name : names) finish(name);
  }

  test::FewFilters filters_;
  Flow flow_{filters_, {10, 2}};
  std::vector<Action> all_;
  std::map<std::string, uint64_t> numbers_;
};

using Names = std::vector<std::string>;

}  // namespace gxy::flow
