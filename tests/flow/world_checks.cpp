// SPDX-License-Identifier: Apache-2.0
// What has to hold in a World, found out without what the Flow says of itself.
#include <algorithm>

#include "tests/flow/world.h"

namespace gxy::test {

using flow::DataId;
using flow::NodeKey;
using flow::TargetId;

bool World::isDemanded(const TargetId& id) const {
  const flow::Document& document = newestDocument();
  if (id.kind == TargetId::Kind::Output)
    return std::any_of(document.outputs.begin(), document.outputs.end(),
                       [&](const flow::OutputSpec& output) { return output.name == id.name; });
  return windows_.contains(id.name) &&
         std::any_of(document.views.begin(), document.views.end(),
                     [&](const flow::ViewSpec& view) { return view.name == id.name; });
}

bool World::isFollowed(const TargetId& id) const {
  return id.kind == TargetId::Kind::Output || windows_.at(id.name);
}

std::vector<std::string> World::shownBy(const flow::Document& document, const TargetId& id) const {
  for (const flow::OutputSpec& output : document.outputs)
    if (id.kind == TargetId::Kind::Output && output.name == id.name) {
      for (const flow::ViewSpec& view : document.views)
        if (view.name == output.of) return view.datasets;
      return {output.of};
    }
  for (const flow::ViewSpec& view : document.views)
    if (id.kind == TargetId::Kind::View && view.name == id.name) return view.datasets;
  return {};
}

std::set<std::string> World::closure(const flow::Document& document,
                                     const std::vector<std::string>& shown) const {
  std::set<std::string> names(shown.begin(), shown.end());
  for (size_t before = 0; before != names.size();) {
    before = names.size();
    for (const DatasetSpec& dataset : document.datasets)
      if (names.contains(dataset.name))
        for (const FilterInput& input : dataset.inputs)
          names.insert(input.datasets.begin(), input.datasets.end());
  }
  return names;
}

std::vector<Origin> World::originsOf(const DataId& data) const {
  if (const auto* id = std::get_if<Id>(&data)) return space_.origins.at(*id);
  return truths_.at(std::get<NodeKey>(data)).origins;
}

// A view changes at once: to all that it shows, but for what has a problem.
void World::checkWhole(const flow::ShowData& action) {
  const flow::Target* target = recent_.back()->target(action.target);
  if (!target || target->asItComes) return;
  const bool isWhole = action.data.size() == target->shows.size() + target->missing.size() &&
                       std::none_of(action.data.begin(), action.data.end(),
                                    [](const flow::ShownData& item) { return item.older; });
  expect(isWhole || !action.problems.empty(), action.target.name + " shows a part, and does not say why");
}

void World::checkQuiet() {
  if (!flow_.isBusy()) runAsked_ = false;
  for (const auto& [number, evaluation] : evaluations_) checkNeeded(evaluation);
  checkPins();
}

void World::checkNeeded(const Evaluation& evaluation) {
  if (evaluation.isCancelled || runAsked_) return;
  for (const auto& compiled : recent_) {
    for (const flow::Target& target : compiled->targets())
      if (isDemanded(target.id))
        for (const std::string& node :
             closure(compiled->document(), shownBy(compiled->document(), target.id)))
          if (matches(*compiled, node, evaluation.what.key)) return;
  }
  expect(false, "nobody needs " + evaluation.what.node + ", which runs");
}

// What is held is shown, or read, or of a source that a wave may read.
void World::checkPins() {
  std::set<DataId> needed;
  for (const auto& [id, seen] : seen_)
    if (isDemanded(id) && !seen.isHeld && !seen.isWritten)
      for (const flow::ShownData& item : seen.what.data) needed.insert(item.data);
  for (const auto& [number, evaluation] : evaluations_)
    for (const auto& input : evaluation.what.inputs)
      for (const auto& item : input.items) needed.insert(item.data);
  for (const auto& [number, hold] : holds_)
    expect(flow_.isBusy() || needed.contains(hold.id), "something is held that nothing needs");
  size_t held = 0;
  for (const auto& [number, hold] : holds_) held += hold.isAdopted ? 1 : 0;
  expect(space_.adopted().size() == held, "something is adopted without a hold");
}

World::Newest World::newest(const flow::CompiledDocument& document, const std::string& name) const {
  const auto place = document.place(name);
  if (!place) return {std::nullopt, name};
  const flow::Node& node = document.nodes()[*place];
  if (node.defect.kind != flow::Defect::Kind::None) return {std::nullopt, node.defect.node};
  if (node.isSource()) {
    for (const ObjectSpace::Name& source : space_.names)
      if (const auto current = space_.current(source); source.name == name && current) return {*current, ""};
    return {};
  }
  std::vector<flow::KeyInput> inputs;
  std::string brokenBy;
  bool hasKey = true;
  for (const flow::Node::Port& port : node.ports) {
    flow::KeyInput& input = inputs.emplace_back();
    input.input = port.input;
    for (size_t read : port.places) {
      const Newest item = newest(document, document.nodes()[read].spec.name);
      if (!item.brokenBy.empty() && brokenBy.empty()) brokenBy = item.brokenBy;
      if (item.data)
        input.data.push_back(*item.data);
      else
        hasKey = false;
    }
  }
  if (!hasKey) return {std::nullopt, brokenBy};
  const NodeKey key = flow::keyOf(node.spec.filter, node.version, node.spec.properties, inputs);
  if (outputs_.contains(key)) return {key, ""};  // whatever has come since of what it was made of
  if (brokenBy.empty() && broken_.contains(key)) brokenBy = name;
  return {key, brokenBy};
}

// Whether an output is made as the document says, of whatever generations.
bool World::matches(const flow::CompiledDocument& document, const std::string& name,
                    const DataId& data) const {
  const auto place = document.place(name);
  if (!place) return false;
  const flow::Node& node = document.nodes()[*place];
  if (node.isSource()) return std::holds_alternative<Id>(data);
  if (std::holds_alternative<Id>(data)) return false;
  const Truth& truth = truths_.at(std::get<NodeKey>(data));
  if (truth.filter != node.spec.filter || truth.properties != node.spec.properties) return false;
  if (node.defect.kind != flow::Defect::Kind::None) return false;
  for (size_t i = 0; i < node.ports.size(); i++)
    if (truth.inputs.at(i).data.size() != node.ports[i].places.size()) return false;
  for (size_t i = 0; i < node.ports.size(); i++)
    for (size_t j = 0; j < node.ports[i].places.size(); j++)
      if (!matches(document, document.nodes()[node.ports[i].places[j]].spec.name, truth.inputs[i].data[j]))
        return false;
  return true;
}

void World::rest() {
  if (paused_) flow_.resume();
  paused_ = false;
  if (hasAsked_) {
    hasAsked_ = false;
    runAsked_ = true;
    broken_.clear();
    flow_.run();
  }
  for (int i = 0; i < 20000 && errors.empty(); i++) {
    if (!due_.empty() && random_.oneIn(4)) publish(1, false);
    announce();
    takeActions();
    carryOut(SIZE_MAX);
    answerAdoption();
    answerEvaluation();
    flow_.tick();
    takeActions();
    if (due_.empty() && unsaid_.empty() && actions_.empty() && evaluations_.empty() && !flow_.isBusy()) break;
  }
  expect(due_.empty() && unsaid_.empty(), "a publisher waits for ever");
  expect(evaluations_.empty() && !flow_.isBusy(), "the graph does not come to rest");
  if (!errors.empty()) return;
  checkQuiet();
  for (const flow::Target& target : flow_.document().targets())
    if (isDemanded(target.id)) checkTarget(target.id, target.follow && isFollowed(target.id));
  for (const flow::Node& node : flow_.document().nodes())
    counters.leftOut += int64_t(flow_.state({flow::NodeId::Kind::Dataset, node.spec.name}).leftOut);
}

std::string World::stateOf(const TargetId& id, const std::string& name) const {
  const auto kind = id.kind == TargetId::Kind::View ? flow::NodeId::Kind::View : flow::NodeId::Kind::Output;
  const flow::NodeState target = flow_.state({kind, id.name});
  const flow::NodeState node = flow_.state({flow::NodeId::Kind::Dataset, name});
  return " (state " + std::to_string(int(target.kind)) + " " + target.text + "; of the node " +
         std::to_string(int(node.kind)) + " " + node.text + ")";
}

void World::checkTarget(const TargetId& id, bool follows) {
  const flow::CompiledDocument& compiled = *recent_.back();
  const std::vector<std::string> shown = shownBy(newestDocument(), id);
  std::map<std::string, Newest> newest;
  for (const std::string& name : shown) newest[name] = this->newest(compiled, name);
  for (const std::string& source : closure(newestDocument(), shown))
    if (const auto place = compiled.place(source);
        place && compiled.nodes()[*place].isSource() && !this->newest(compiled, source).data) {
      // Nothing of the target can be newest without it, unless only what cannot be evaluated reads it.
      counters.missing++;
      return;
    }
  const auto found = seen_.find(id);
  if (found == seen_.end()) return expect(false, id.name + " shows nothing");
  const Seen& seen = found->second;
  expect(!seen.isHeld || seen.isWritten, id.name + " holds its picture");
  for (const auto& [name, is] : newest) {
    const auto item = std::find_if(seen.what.data.begin(), seen.what.data.end(),
                                   [&, n = name](const flow::ShownData& data) { return data.node == n; });
    const bool isThere = item != seen.what.data.end() && !item->older;
    if (!follows) {
      if (isThere)
        expect(matches(compiled, name, item->data), id.name + ": " + name + " is of an older document");
    } else if (is.brokenBy.empty()) {
      expect(isThere && item->data == *is.data,
             id.name + " does not show the newest " + name + stateOf(id, name));
    } else {
      expect(!isThere, id.name + " shows " + name + ", which cannot be made");
      expect(std::any_of(seen.what.problems.begin(), seen.what.problems.end(),
                         [](const flow::Problem& problem) { return !problem.node.empty(); }),
             id.name + " does not say why " + name + " is missing");
    }
  }
}

void World::leave() {
  for (const auto& [view, follows] : windows_) flow_.hide(view);
  windows_.clear();
  flow::Document document = newestDocument();
  document.outputs.clear();
  flow_.edit(document);
  recent_.clear();
  take(document);
  std::erase_if(seen_, [&](const auto& item) { return !isDemanded(item.first); });
  while (flow_.makeRoom()) continue;
  takeActions();
  carryOut(SIZE_MAX);
  expect(evaluations_.empty(), "something runs for nobody");
  expect(holds_.empty() && space_.pins().empty() && space_.adopted().empty(), "something is held for nobody");
  expect(outputs_.empty(), "an output is kept for nobody");
}

}  // namespace gxy::test
