// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_passes.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "core/comm/error.h"

namespace gxy {
namespace {

using Halo = std::array<int, 3>;

/// Where a value is stored.
struct Stored {
  int32_t source = -1, component = -1;
};

/// The steps of one stage.
class StageBuilder {
 public:
  StageBuilder(const FieldGraph& graph, const std::vector<int32_t>& windowOf,
               const std::vector<Stored>& stored)
      : graph_(graph), windowOf_(windowOf), stored_(stored) {}

  /// Computes `roots`, which are windows or, if `results`, the results of the pass.
  FieldStage build(const std::vector<int32_t>& roots, bool results) {
    collect(roots, results);
    const size_t n = order_.size();
    std::map<int32_t, size_t> lastUse;
    for (size_t i = 0; i < n; ++i)
      if (!isLoad(order_[i]))
        for (int o = 0; o < operandsOf(value(order_[i]).op); ++o)
          lastUse[value(order_[i]).operands[size_t(o)]] = i;
    if (results)
      for (const int32_t root : roots) lastUse[root] = n;
    for (size_t i = 0; i < n; ++i) {
      addStep(order_[i], results);
      for (const auto& [operand, last] : ending(i, lastUse)) release(operand);
    }
    if (results)
      for (const int32_t root : roots) stage_.results.push_back(inRegister(root));
    return std::move(stage_);
  }

  int registers() const { return registers_; }

 private:
  const PointValue& value(int32_t v) const { return graph_.values[size_t(v)]; }
  bool isStored(int32_t v) const { return stored_[size_t(v)].source >= 0; }
  bool isLoad(int32_t v) const { return isStored(v) || value(v).op == PointOp::Load; }
  bool isWindow(int32_t v) const { return windowOf_[size_t(v)] >= 0; }

  /// Lists what has to be computed here, operands first. Windows of other stages are there already.
  void collect(const std::vector<int32_t>& roots, bool results) {
    std::vector<bool> needed(graph_.values.size());
    int32_t highest = -1;
    for (const int32_t root : roots)
      if (!(results && isWindow(root))) needed[size_t(root)] = true, highest = std::max(highest, root);
    for (int32_t v = highest; v >= 0; --v) {
      if (!needed[size_t(v)] || isLoad(v)) continue;
      for (int o = 0; o < operandsOf(value(v).op); ++o) {
        const int32_t operand = value(v).operands[size_t(o)];
        if (!isWindow(operand)) needed[size_t(operand)] = true;
      }
    }
    for (int32_t v = 0; v <= highest; ++v)
      if (needed[size_t(v)] && value(v).op != PointOp::Number) order_.push_back(v);
  }

  std::vector<std::pair<int32_t, size_t>> ending(size_t i, const std::map<int32_t, size_t>& lastUse) const {
    std::vector<std::pair<int32_t, size_t>> all;
    if (isLoad(order_[i])) return all;
    for (int o = 0; o < operandsOf(value(order_[i]).op); ++o) {
      const auto use = lastUse.find(value(order_[i]).operands[size_t(o)]);
      if (use != lastUse.end() && use->second == i) all.push_back(*use);
    }
    return all;
  }

  PointPlace take() {
    int32_t index = next_;
    if (free_.empty()) {
      registers_ = std::max(registers_, ++next_);
      if (next_ > kMostRegisters)
        throw Error("expression: more than " + std::to_string(kMostRegisters) +
                    " values are needed at once, expected fewer that are used again later");
    } else {
      index = free_.back();
      free_.pop_back();
    }
    return {PointPlace::Kind::Register, index, 0};
  }

  void release(int32_t v) {
    const auto at = places_.find(v);
    if (at == places_.end() || at->second.kind != PointPlace::Kind::Register) return;
    free_.push_back(at->second.index);
    places_.erase(at);
  }

  PointPlace placeOf(int32_t v) const {
    if (value(v).op == PointOp::Number) return {PointPlace::Kind::Number, -1, value(v).number};
    if (const auto at = places_.find(v); at != places_.end()) return at->second;
    return {PointPlace::Kind::Window, windowOf_[size_t(v)], 0};
  }

  /// The place of a value, in a register of its own if it is a number.
  PointPlace inRegister(int32_t v) {
    PointPlace place = placeOf(v);
    if (place.kind != PointPlace::Kind::Number) return place;
    PointStep fill;
    fill.operands[0] = place;
    fill.to = place = take();
    stage_.steps.push_back(fill);
    return place;
  }

  void addStep(int32_t v, bool results) {
    const PointValue& made = value(v);
    PointStep step;
    step.op = isStored(v) ? PointOp::Load : made.op;
    step.axis = made.axis;
    step.source = isStored(v) ? stored_[size_t(v)].source : made.source;
    step.component = isStored(v) ? stored_[size_t(v)].component : made.component;
    std::vector<int32_t> filled;
    if (!isLoad(v)) {
      for (size_t o = 0; o < size_t(operandsOf(made.op)); ++o) {
        const bool mayBeNumber = takesNumbers(made.op) && !(made.op == PointOp::If && o == 0);
        step.operands[o] = mayBeNumber ? placeOf(made.operands[o]) : inRegister(made.operands[o]);
        if (value(made.operands[o]).op == PointOp::Number && !mayBeNumber)
          filled.push_back(step.operands[o].index);
      }
    }
    step.to =
        !results && isWindow(v) ? PointPlace{PointPlace::Kind::Window, windowOf_[size_t(v)], 0} : take();
    if (step.to.kind == PointPlace::Kind::Window)
      stage_.windows.push_back(step.to.index);
    else
      places_[v] = step.to;
    stage_.steps.push_back(step);
    free_.insert(free_.end(), filled.begin(), filled.end());
  }

  const FieldGraph& graph_;
  const std::vector<int32_t>& windowOf_;
  const std::vector<Stored>& stored_;
  std::vector<int32_t> order_;
  std::map<int32_t, PointPlace> places_;
  std::vector<int32_t> free_;
  int32_t next_ = 0;
  int registers_ = 0;
  FieldStage stage_;
};

class Planner {
 public:
  Planner(const FieldGraph& graph, int inputs, int ghosts)
      : graph_(graph), inputs_(inputs), ghosts_(ghosts) {}

  std::vector<FieldPass> passes() {
    chooseStored();
    std::vector<FieldPass> all;
    for (int level = 0; level < levels_; ++level) {
      std::vector<int32_t> made;
      for (size_t v = 0; v < size(); ++v)
        if (isStored_[v] && level_[v] == level) made.push_back(int32_t(v));
      all.push_back(pass(made));
      for (size_t i = 0; i < made.size(); ++i) stored_[size_t(made[i])] = {inputs_ + level, int32_t(i)};
    }
    all.push_back(pass(graph_.results));
    return all;
  }

 private:
  size_t size() const { return graph_.values.size(); }
  const PointValue& value(int32_t v) const { return graph_.values[size_t(v)]; }
  template <class Use>
  void forOperands(int32_t v, Use use) const {
    for (int o = 0; o < operandsOf(value(v).op); ++o) use(value(v).operands[size_t(o)]);
  }

  /// Marks what must be stored, so that no value needs more layers around it than there are.
  void chooseStored() {
    std::vector<bool> used(size());
    for (const int32_t r : graph_.results) used[size_t(r)] = true;
    for (auto v = int32_t(size()) - 1; v >= 0; --v)
      if (used[size_t(v)]) forOperands(v, [&](int32_t o) { used[size_t(o)] = true; });
    std::vector<int> layers(size());
    isStored_.assign(size(), false);
    level_.assign(size(), 0);
    stored_.assign(size(), {});
    for (int32_t v = 0; v < int32_t(size()); ++v) {
      if (!used[size_t(v)]) continue;
      const int reach = reachOf(value(v).op);
      forOperands(v, [&](int32_t o) {
        if (reach > 0 && layers[size_t(o)] + reach > ghosts_) isStored_[size_t(o)] = true;
        if (isStored_[size_t(o)]) layers[size_t(o)] = 0;
        layers[size_t(v)] = std::max(layers[size_t(v)], layers[size_t(o)] + reach);
      });
    }
    for (int32_t v = 0; v < int32_t(size()); ++v) {
      forOperands(v, [&](int32_t o) {
        level_[size_t(v)] = std::max(level_[size_t(v)], level_[size_t(o)] + int(isStored_[size_t(o)]));
      });
      if (isStored_[size_t(v)]) levels_ = std::max(levels_, level_[size_t(v)] + 1);
    }
  }

  bool isLeaf(int32_t v) const { return stored_[size_t(v)].source >= 0; }

  FieldPass pass(const std::vector<int32_t>& results) const {
    std::vector<bool> needed(size());
    for (const int32_t r : results) needed[size_t(r)] = true;
    std::vector<bool> isWindow(size());
    std::vector<Halo> halo(size(), Halo{0, 0, 0});
    for (auto v = int32_t(size()) - 1; v >= 0; --v) {
      if (!needed[size_t(v)] || isLeaf(v)) continue;
      const int reach = reachOf(value(v).op);
      forOperands(v, [&](int32_t o) {
        needed[size_t(o)] = true;
        if (reach > 0) isWindow[size_t(o)] = true;
        for (int a = 0; a < 3; ++a)
          halo[size_t(o)][size_t(a)] = std::max(
              halo[size_t(o)][size_t(a)], halo[size_t(v)][size_t(a)] + (a == value(v).axis ? reach : 0));
      });
    }
    FieldPass made;
    std::map<std::pair<int, Halo>, std::vector<int32_t>> stages;
    std::vector<int> depth(size());  // of windows that a value is made of
    std::vector<int32_t> windowOf(size(), -1);
    for (int32_t v = 0; v < int32_t(size()); ++v) {
      if (!needed[size_t(v)]) continue;
      if (!isLeaf(v))
        forOperands(v, [&](int32_t o) {
          depth[size_t(v)] = std::max(depth[size_t(v)], depth[size_t(o)] + int(isWindow[size_t(o)]));
        });
      if (!isWindow[size_t(v)]) continue;
      windowOf[size_t(v)] = int32_t(made.windows.size());
      made.windows.push_back(halo[size_t(v)]);
      stages[{depth[size_t(v)], halo[size_t(v)]}].push_back(v);
    }
    for (const auto& [key, roots] : stages) addStage(made, windowOf, roots, false, key.second);
    addStage(made, windowOf, results, true, {0, 0, 0});
    return made;
  }

  void addStage(FieldPass& made, const std::vector<int32_t>& windowOf, const std::vector<int32_t>& roots,
                bool results, const Halo& halo) const {
    StageBuilder builder(graph_, windowOf, stored_);
    made.stages.push_back(builder.build(roots, results));
    made.stages.back().halo = halo;
    made.registers = std::max(made.registers, builder.registers());
    for (const PointStep& step : made.stages.back().steps)
      if (step.op == PointOp::Load && std::ranges::find(made.sources, step.source) == made.sources.end())
        made.sources.push_back(step.source);
  }

  const FieldGraph& graph_;
  const int inputs_, ghosts_;
  int levels_ = 0;
  std::vector<bool> isStored_;
  std::vector<int> level_;  ///< passes that come before the one that computes a value
  std::vector<Stored> stored_;
};

}  // namespace

std::vector<FieldPass> passesOf(const FieldGraph& graph, int inputs, int ghosts) {
  return Planner(graph, inputs, ghosts).passes();
}

}  // namespace gxy
