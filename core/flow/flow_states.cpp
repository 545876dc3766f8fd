// SPDX-License-Identifier: Apache-2.0
// What users are told of each node.
#include <algorithm>

#include "core/comm/error_text.h"
#include "core/flow/flow.h"

namespace gxy::flow {

using State = NodeState::Kind;

void Flow::tell(const NodeId& id, const NodeState& state) {
  const auto [at, isNew] = states_.try_emplace(id, state);
  if (!isNew && at->second == state) return;
  at->second = state;
  actions_.push_back(ChangeState{id, state});
}

void Flow::tellStates() {
  std::erase_if(states_, [&](const auto& item) {
    const NodeId& id = item.first;
    if (id.kind == NodeId::Kind::Dataset) return !document_->place(id.name);
    const auto kind = id.kind == NodeId::Kind::View ? TargetId::Kind::View : TargetId::Kind::Output;
    return !document_->target({kind, id.name});
  });
  std::set<std::string> older;
  for (const auto& [id, shown] : shown_)
    for (const ShownData& item : shown.picture.data)
      if (item.older) older.insert(item.node);
  const Step step = presentStep();
  std::vector<size_t> all;
  for (size_t at = 0; at < document_->nodes().size(); at++)
    if (document_->nodes()[at].isSource()) all.push_back(at);
  all.insert(all.end(), document_->order().begin(), document_->order().end());
  const auto keys = keys_->of(all, step);
  const auto outcome = outcomes(*keys_, all, step, stock_);
  for (size_t at : all) {
    const Node& node = document_->nodes()[at];
    NodeState state = node.isSource() ? stateOfSource(node) : stateOfFilter(at, outcome[at], keys[at]);
    state.showsOlder = older.contains(node.spec.name);
    tell({NodeId::Kind::Dataset, node.spec.name}, state);
  }
  for (const Target& target : document_->targets()) {
    const bool isView = target.id.kind == TargetId::Kind::View;
    tell({isView ? NodeId::Kind::View : NodeId::Kind::Output, target.id.name}, stateOfTarget(target));
  }
}

// What states are about: the step of the wave, and the newest data of what it does not read.
Step Flow::presentStep() const {
  Step step = wave_ ? wave_->step : Step();
  step.merge(newestData());
  return step;
}

Step Flow::newestData() const {
  Step step;
  for (const Node& node : document_->nodes())
    if (const auto found = sources_.find(node.spec.name);
        node.isSource() && found != sources_.end() && found->second.current)
      step.emplace(node.spec.name, *found->second.current);
  return step;
}

NodeState Flow::stateOfSource(const Node& node) const {
  NodeState state;
  const auto found = sources_.find(node.spec.name);
  if (found != sources_.end()) state.leftOut = found->second.leftOut;
  if (const auto failure = stock_.sourceFailures.find(node.spec.name);
      failure != stock_.sourceFailures.end()) {
    state.kind = State::Failed;
    state.text = failure->second.text;
    state.rank = failure->second.rank;
  } else if (found != sources_.end() && found->second.current) {
    state.kind = State::Done;
    state.generation = found->second.current->id.generation;
  } else {
    state.text = node.spec.filename.empty() ? "for data of this name" : "for its file";
  }
  return state;
}

NodeState Flow::stateOfFilter(size_t place, const Outcome& outcome, const std::optional<NodeKey>& key) const {
  const Node& node = document_->nodes()[place];
  NodeState state;
  if (node.defect.kind != Defect::Kind::None) {
    state.kind = node.defect.kind == Defect::Kind::Incomplete ? State::Incomplete : State::Blocked;
    state.text = node.defect.text;
    if (state.kind == State::Blocked) state.by = node.defect.node;
    return state;
  }
  if (const Evaluation* evaluation = running(node, key)) {
    state.kind = State::Running;
    state.done = evaluation->done;
    state.of = evaluation->of;
    state.text = evaluation->text;
    return state;
  }
  if (outcome.kind == Outcome::Kind::There) {
    const Made& made = stock_.outputs.find(*key)->made;
    state.kind = State::Done;
    state.generation = made.generation;
    state.seconds = made.seconds;
    state.bytes = made.bytes;
    state.output = key;
    return state;
  }
  if (outcome.kind == Outcome::Kind::Pending) return stateOfPending(place, key);
  state.text = outcome.problem.text;
  state.rank = outcome.problem.rank;
  state.kind = !outcome.isCause ? State::Blocked : outcome.problem.cancelled ? State::Stale : State::Failed;
  if (!outcome.isCause) state.by = outcome.problem.node;
  const auto source = document_->place(outcome.problem.node);
  const bool waits = !outcome.isCause && document_->nodes()[*source].isSource() &&
                     !stock_.sourceFailures.contains(outcome.problem.node);
  if (waits) {
    state = NodeState();
    state.text = "for " + inQuotes(outcome.problem.node);
  }
  return state;
}

// A node that is to be evaluated, now or when somebody needs it.
NodeState Flow::stateOfPending(size_t place, const std::optional<NodeKey>& key) const {
  const Node& node = document_->nodes()[place];
  NodeState state;
  if (wave_ && wave_->keys == keys_) {
    const Needs& needs = needs_;
    if (std::count(needs.pending.begin(), needs.pending.end(), place) > 0) {
      for (const Node::Port& port : node.ports)
        for (size_t read : port.places)
          if (needs.outcomes[read].kind != Outcome::Kind::There && state.text.empty())
            state.text = "for " + inQuotes(document_->nodes()[read].spec.name);
      state.kind = state.text.empty() ? State::Queued : State::Waiting;
      return state;
    }
  }
  bool isNeeded = false;
  for (const Target& target : demanded())
    isNeeded = isNeeded || std::count(target.closure.begin(), target.closure.end(), place) > 0;
  const auto last = stock_.lastGood.find(node.spec.name);
  const bool hasOlder = last != stock_.lastGood.end() && stock_.outputs.find(last->second) && key;
  state.kind = hasOlder ? State::Stale : State::Waiting;
  state.text = !isNeeded ? "nothing needs it"
               : paused_ ? "paused"
               : wave_   ? "for the wave that runs"
                         : "for its data";
  return state;
}

const Flow::Evaluation* Flow::running(const Node& node, const std::optional<NodeKey>& key) const {
  for (const auto& [number, evaluation] : evaluations_) {
    if (evaluation.isCancelled) continue;
    // While an edit waits, what runs is of an older document: it goes by its name.
    const bool isOlder = wave_ && wave_->keys != keys_ && evaluation.node == node.spec.name;
    if ((key && evaluation.key == *key) || isOlder) return &evaluation;
  }
  return nullptr;
}

NodeState Flow::stateOfTarget(const Target& target) const {
  NodeState state;
  const auto found = shown_.find(target.id);
  const auto waiting = waiting_.find(target.id);
  if (!isDemanded(target.id)) {
    state.text = "no window shows it";
  } else if (wave_ && wave_->targets.contains(target.id)) {
    state.kind = State::Running;
  } else if (found == shown_.end() || !found->second.hasPicture) {
    state.text = waiting != waiting_.end() ? waiting->second : "";
  } else if (found->second.isHeld) {
    state.kind = State::Stale;
    state.text = "held picture: " + found->second.heldBecause;
  } else if (waiting != waiting_.end()) {
    state.kind = State::Stale;
    state.text = waiting->second;
  } else if (!found->second.picture.problems.empty()) {
    const Problem& problem = found->second.picture.problems[0];
    state.kind = State::Blocked;
    state.by = problem.node;
    state.text = problem.text;
    state.rank = problem.rank;
  } else {
    state.kind = State::Done;
  }
  return state;
}

}  // namespace gxy::flow
