// SPDX-License-Identifier: Apache-2.0
// What a Flow is told.
#include "core/flow/flow.h"

#include <algorithm>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy::flow {

Flow::Flow(const FilterSchemas& filters, Options options)
    : filters_(filters),
      options_(options),
      document_(std::make_shared<const CompiledDocument>()),
      keys_(std::make_shared<NodeKeys>(document_)) {}

uint64_t Flow::edit(const Document& document, bool live) {
  auto compiled = std::make_shared<const CompiledDocument>(document, filters_);
  if (document == document_->document()) return revision_;
  resetChangedFiles(*compiled);
  for (const OutputSpec& output : document_->document().outputs)
    if (std::count(document.outputs.begin(), document.outputs.end(), output) == 0)
      shown_.erase({TargetId::Kind::Output, output.name});
  document_ = std::move(compiled);
  keys_ = std::make_shared<NodeKeys>(document_);
  revision_++;
  isLive_ = live;
  if (wave_ && !(live && wave_->live)) {
    preferred_ = wave_->step;
    wave_.reset();
  }
  if (paused_) {
    allowed_.clear();
    runs_.clear();
  }
  for (auto it = runs_.begin(); it != runs_.end();) {
    const auto place = document_->place(it->first.name);
    if (place && document_->nodes()[*place].canEvaluate())
      (it++)->second = document_->only(*place);
    else
      it = runs_.erase(it);
  }
  for (auto it = stock_.lastGood.begin(); it != stock_.lastGood.end();)
    it = document_->place(it->first) ? std::next(it) : stock_.lastGood.erase(it);
  settle();
  return revision_;
}

// A name that means another file than before is a source that is not there.
void Flow::resetChangedFiles(const CompiledDocument& newer) {
  const auto specOf = [](const CompiledDocument& document, const std::string& name) -> const DatasetSpec* {
    const auto place = document.place(name);
    return place ? &document.nodes()[*place].spec : nullptr;
  };
  const auto isFile = [](const DatasetSpec* spec) { return spec && !spec->filename.empty(); };
  std::set<std::string> names;
  for (const Node& node : document_->nodes()) names.insert(node.spec.name);
  for (const Node& node : newer.nodes()) names.insert(node.spec.name);
  for (const std::string& name : names) {
    const DatasetSpec* before = specOf(*document_, name);
    const DatasetSpec* after = specOf(newer, name);
    if (!isFile(before) && !isFile(after)) continue;
    if (before && after) {
      DatasetSpec recolored = *before;
      recolored.color = after->color;
      if (recolored == *after) continue;
    }
    sources_.erase(name);
    stock_.sourceFailures.erase(name);
  }
}

void Flow::update(const std::string& name, const SourceData& data) {
  update(std::vector<Update>{{name, data}});
}

void Flow::update(std::span<const Update> updates) {
  std::set<std::string> needed;
  for (const Target& target : demanded())
    if (target.follow && isAllowed(target.id))
      for (size_t source : target.sources) needed.insert(document_->nodes()[source].spec.name);
  for (const Update& update : updates) {
    Source& source = sources_[update.name];
    const bool isOlder = source.current && source.current->id.object == update.data.id.object &&
                         source.current->id.generation >= update.data.id.generation;
    if (isOlder) continue;
    if (source.current && !source.isTaken && needed.contains(update.name)) source.leftOut++;
    source.current = update.data;
    source.isTaken = false;
    stock_.sourceFailures.erase(update.name);
  }
  settle();
}

void Flow::dropped(const std::string& name) {
  const auto found = sources_.find(name);
  if (found == sources_.end()) return;
  found->second.current.reset();
  found->second.isFetched = false;
  settle();
}

void Flow::sourceFailed(const std::string& name, const std::string& text, int rank) {
  if (const auto found = sources_.find(name); found != sources_.end()) found->second.current.reset();
  stock_.sourceFailures[name] = {name, text, rank};
  settle();
}

void Flow::wanted(const SourceGeneration& generation) { holds_.want(generation, now_); }

void Flow::lost(const SourceGeneration& generation) {
  for (auto& [name, source] : sources_)
    if (source.current && source.current->id == generation) source.current.reset();
  holds_.forget(generation);
  hold(generation, "its data are gone");
  const auto isLost = [&](const auto& item) { return item.second.id == generation; };
  if (wave_ && std::any_of(wave_->step.begin(), wave_->step.end(), isLost)) wave_.reset();
  settle();
}

// Targets that show these data keep their last picture.
void Flow::hold(const DataId& data, const std::string& text) {
  for (auto& [id, shown] : shown_) {
    if (!shown.needs(data)) continue;
    shown.isHeld = true;
    shown.heldBecause = text;
    showing_[id] = HoldPicture{id, text};
  }
}

bool Flow::Shown::needs(const DataId& data) const {
  return hasPicture && !isHeld && !isWritten &&
         std::any_of(picture.data.begin(), picture.data.end(),
                     [&](const ShownData& item) { return item.data == data; });
}

void Flow::show(const std::string& view, bool follow) {
  const auto [shown, isNew] = windows_.try_emplace(view, follow);
  if (!isNew && shown->second == follow) return;
  shown->second = follow;
  settle();
}

void Flow::hide(const std::string& view) {
  if (windows_.erase(view) > 0) settle();
}

void Flow::pause() {
  paused_ = true;
  allowed_.clear();
  settle();
}

void Flow::resume() {
  paused_ = false;
  allowed_.clear();
  settle();
}

size_t Flow::placeOf(const std::string& node) const {
  const auto place = document_->place(node);
  if (!place) throw Error("there is no dataset " + inQuotes(node) + " in the graph");
  return *place;
}

void Flow::run() {
  stock_.failures.clear();
  for (const Target& target : demanded()) {
    allowed_.insert(target.id);
    if (target.id.kind == TargetId::Kind::Output) shown_.erase(target.id);
    shown_[target.id].isAsked = true;
  }
  ask(document_->everything());
}

void Flow::run(const std::string& node) { ask({document_->only(placeOf(node))}); }

void Flow::ask(const std::vector<Target>& targets) {
  const Step present = presentStep(), newest = newestData();
  for (const Target& target : targets) {
    const auto presentKeys = keys_->of(target.closure, present),
               newestKeys = keys_->of(target.closure, newest);
    for (size_t at : target.closure) {
      if (presentKeys[at]) stock_.failures.remove(*presentKeys[at]);
      if (newestKeys[at]) stock_.failures.remove(*newestKeys[at]);
      const std::string& name = document_->nodes()[at].spec.name;
      if (stock_.sourceFailures.erase(name) > 0) sources_[name].isFetched = false;
    }
    runs_[target.id] = target;
    allowed_.insert(target.id);
  }
  settle();
}

void Flow::cancel() { cancelNodes(std::nullopt); }

void Flow::cancel(const std::string& node) {
  placeOf(node);
  cancelNodes(node);
}

void Flow::cancelNodes(const std::optional<std::string>& node) {
  if (!wave_) return;
  const Needs needs = needsOf(*wave_);
  for (size_t at : needs.pending) {
    const std::string& name = wave_->keys->document().nodes()[at].spec.name;
    if (!node || name == *node) stock_.failures.add(*needs.keys[at], {name, "cancelled", -1, true});
  }
  settle();
}

void Flow::written(const std::string& output, uint64_t wave) {
  const auto found = shown_.find({TargetId::Kind::Output, output});
  if (found == shown_.end() || found->second.wave != wave) return;
  found->second.isWritten = true;
  settle();
}

void Flow::progress(uint64_t evaluation, double done, double of, const std::string& text) {
  const auto found = evaluations_.find(evaluation);
  if (found == evaluations_.end()) return;
  found->second.done = done;
  found->second.of = of;
  found->second.text = text;
  tellStates();
}

void Flow::finished(uint64_t evaluation, const Made& made) {
  const auto found = evaluations_.find(evaluation);
  if (found == evaluations_.end()) return;
  stock_.outputs.add(found->second.key, made, found->second.origins);
  stock_.failures.remove(found->second.key);
  evaluations_.erase(found);
  settle();
}

void Flow::failed(uint64_t evaluation, const std::string& text, int rank) {
  const auto found = evaluations_.find(evaluation);
  if (found == evaluations_.end()) return;
  stock_.failures.add(found->second.key, {found->second.node, text, rank});
  evaluations_.erase(found);
  settle();
}

void Flow::cancelled(uint64_t evaluation) {
  const auto found = evaluations_.find(evaluation);
  if (found == evaluations_.end()) return;
  if (!found->second.isCancelled)
    stock_.failures.add(found->second.key, {found->second.node, "cancelled", -1, true});
  evaluations_.erase(found);
  settle();
}

void Flow::adopted(uint64_t hold) { holds_.adopted(hold); }

void Flow::refused(uint64_t hold, const std::string& text) {
  const auto generation = holds_.refused(hold, now_);
  if (!generation) return;
  this->hold(*generation, text);
  settle();
}

void Flow::tick(uint64_t ticks) {
  now_ += ticks;
  const auto isNeeded = [&](const SourceGeneration& id) { return needed_.contains(id); };
  holds_.adopt(now_, options_.adoptAfter, isNeeded, actions_);
}

bool Flow::makeRoom() {
  const auto oldest = stock_.outputs.oldest(kept_);
  if (!oldest) return false;
  stock_.outputs.remove(*oldest);
  actions_.push_back(DropOutput{*oldest});
  tellStates();
  return true;
}

void Flow::evicted(const NodeKey& key) {
  if (!stock_.outputs.remove(key)) return;
  hold(key, "an output was given up");
  settle();
}

std::vector<Action> Flow::take() { return std::exchange(actions_, {}); }

NodeState Flow::state(const NodeId& node) const {
  const auto found = states_.find(node);
  return found == states_.end() ? NodeState() : found->second;
}

}  // namespace gxy::flow
