// SPDX-License-Identifier: Apache-2.0
// What a wave takes: generations, outputs, evaluations.
#include <algorithm>

#include "core/flow/flow.h"

namespace gxy::flow {

// The order matters: data are pinned before they are shown or read, and released afterwards.
void Flow::work() {
  needs_ = wave_ ? needsOf(*wave_) : Needs();
  std::vector<Action> releases;
  holdWhatIsNeeded(releases);
  cancelNeedless();
  fetchSources();
  for (auto& [id, action] : showing_) actions_.push_back(std::move(action));
  showing_.clear();
  startReady();
  actions_.insert(actions_.end(), releases.begin(), releases.end());
}

std::vector<size_t> Flow::closureOf(const Wave& wave) {
  const CompiledDocument& document = wave.keys->document();
  std::vector<bool> isNeeded(document.nodes().size());
  std::vector<size_t> closure;
  for (const auto& [id, target] : wave.targets)
    for (size_t at : target.closure) {
      if (document.nodes()[at].isSource() && !isNeeded[at]) closure.push_back(at);
      isNeeded[at] = true;
    }
  for (size_t at : document.order())
    if (isNeeded[at]) closure.push_back(at);
  return closure;
}

// Goes from what targets show to what is still to be made, and no further: what an output was made of is not needed.
Flow::Needs Flow::needsOf(const Wave& wave) const {
  const CompiledDocument& document = wave.keys->document();
  const std::vector<size_t> closure = closureOf(wave);
  Needs needs;
  needs.keys = wave.keys->of(closure, wave.step);
  needs.outcomes = outcomes(*wave.keys, closure, wave.step, stock_);
  std::vector<bool> isNeeded(document.nodes().size());
  for (const auto& [id, target] : wave.targets)
    for (size_t shown : target.shows) {
      const Outcome& outcome = needs.outcomes[shown];
      if (outcome.kind == Outcome::Kind::Pending) isNeeded[shown] = true;
      if (outcome.kind == Outcome::Kind::There && id.kind != TargetId::Kind::Run)
        needs.data.insert(outcome.data);
    }
  for (auto at = closure.rbegin(); at != closure.rend(); ++at) {
    if (!isNeeded[*at]) continue;
    needs.pending.push_back(*at);
    for (const Node::Port& port : document.nodes()[*at].ports)
      for (size_t read : port.places) {
        const Outcome& outcome = needs.outcomes[read];
        if (outcome.kind == Outcome::Kind::Pending) isNeeded[read] = true;
        if (outcome.kind == Outcome::Kind::There) needs.data.insert(outcome.data);
      }
  }
  std::reverse(needs.pending.begin(), needs.pending.end());
  return needs;
}

void Flow::cancelNeedless() {
  std::set<NodeKey> needed;
  for (size_t at : needs_.pending)
    if (needs_.keys[at]) needed.insert(*needs_.keys[at]);
  for (auto& [number, evaluation] : evaluations_) {
    if (evaluation.isCancelled || needed.contains(evaluation.key)) continue;
    evaluation.isCancelled = true;
    actions_.push_back(CancelEvaluation{number});
  }
}

void Flow::startReady() {
  for (size_t at : needs_.pending) {
    if (evaluations_.size() >= options_.evaluations) return;
    // An equal node, or this one before it was cancelled, has to end first.
    const bool runs = std::any_of(evaluations_.begin(), evaluations_.end(),
                                  [&](const auto& item) { return item.second.key == *needs_.keys[at]; });
    const Node& node = wave_->keys->document().nodes()[at];
    const bool isReady = std::all_of(node.ports.begin(), node.ports.end(), [&](const Node::Port& port) {
      return std::all_of(port.places.begin(), port.places.end(),
                         [&](size_t read) { return needs_.outcomes[read].kind == Outcome::Kind::There; });
    });
    if (!runs && isReady) start(at);
  }
}

void Flow::start(size_t place) {
  const std::vector<Node>& nodes = wave_->keys->document().nodes();
  const Node& node = nodes[place];
  StartEvaluation action{nextEvaluation_++,
                         node.spec.name,
                         *needs_.keys[place],
                         node.spec.filter,
                         node.version,
                         node.spec.properties,
                         {}};
  Evaluation evaluation{*needs_.keys[place], node.spec.name, {}, {}, false, 0, 0, ""};
  for (const Node::Port& port : node.ports) {
    StartEvaluation::Input& input = action.inputs.emplace_back();
    input.input = port.input;
    for (size_t read : port.places) {
      const DataId& data = needs_.outcomes[read].data;
      const std::string& name = nodes[read].spec.name;
      input.items.push_back({name, data});
      evaluation.reads.insert(data);
      const NodeKey* key = std::get_if<NodeKey>(&data);
      if (key) stock_.outputs.use(*key);
      evaluation.origins = joined(evaluation.origins,
                                  key ? stock_.outputs.find(*key)->origins : originsOf(wave_->step.at(name)));
    }
  }
  evaluations_.emplace(action.evaluation, std::move(evaluation));
  actions_.push_back(std::move(action));
}

void Flow::fetchSources() {
  for (const Target& target : demanded()) {
    if (!isAllowed(target.id)) continue;
    for (size_t at : target.sources) {
      const DatasetSpec& spec = document_->nodes()[at].spec;
      Source& source = sources_[spec.name];
      if (spec.filename.empty() || source.current || source.isFetched) continue;
      if (stock_.sourceFailures.contains(spec.name)) continue;
      source.isFetched = true;
      actions_.push_back(FetchSource{spec.name});
    }
  }
}

void Flow::holdWhatIsNeeded(std::vector<Action>& releases) {
  needed_ = needs_.data;
  const auto pin = [&](const Step& step, const std::set<DataId>& wanted) {
    for (const auto& [name, data] : step)
      if (wanted.contains(data.id)) holds_.pin(name, data, actions_);
  };
  if (wave_) pin(wave_->step, needs_.data);
  for (const auto& [id, shown] : shown_) {
    std::set<DataId> wanted;
    for (const ShownData& item : shown.picture.data)
      if (shown.needs(item.data)) wanted.insert(item.data);
    pin(shown.step, wanted);
    needed_.merge(wanted);
  }
  std::set<DataId> kept = needed_;
  for (const auto& [number, evaluation] : evaluations_)
    kept.insert(evaluation.reads.begin(), evaluation.reads.end());
  holds_.keepOnly([&](const SourceGeneration& id) { return kept.contains(id); }, releases);
  kept_.clear();
  for (const DataId& data : kept)
    if (const auto* key = std::get_if<NodeKey>(&data)) kept_.insert(*key);
}

}  // namespace gxy::flow
