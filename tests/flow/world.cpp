// SPDX-License-Identifier: Apache-2.0
#include "tests/flow/world.h"

#include <algorithm>

namespace gxy::test {

using flow::TargetId;

World::World(uint64_t seed) : random_(seed), flow_(filters_, {1 + random_.below(20), 2}) {
  const uint64_t publishers = 1 + random_.below(2);
  const uint64_t sources = 2 + random_.below(4);
  for (uint64_t i = 0; i < sources; i++)
    space_.addName("s" + std::to_string(i), random_.below(publishers + 1));
  drawn_.emplace(random_, sources);
  take(drawn_->document());
  flow_.edit(newestDocument());
  for (uint64_t publisher = 0; publisher <= publishers; publisher++) steps_[publisher] = 0;
}

void World::run(int events) {
  for (int i = 0; i < events && errors.empty(); i++) {
    event();
    takeActions();
    if (random_.oneIn(2)) carryOut(1 + random_.below(8));
    if (random_.oneIn(4)) carryOut(SIZE_MAX);
    if (actions_.empty()) checkQuiet();
  }
}

void World::event() {
  switch (random_.below(16)) {
    case 0:
    case 1:
    case 2:
      return publish(random_.below(steps_.size()), random_.oneIn(3));
    case 3:
    case 4:
      return announce();
    case 5:
      return random_.oneIn(3) ? dropOrImport() : void();
    case 6:
      return edit();
    case 7:
    case 8:
      return changeDemand();
    case 9:
      return flow_.tick(1 + random_.below(8));
    case 10:
      return answerAdoption();
    default:
      return answer();
  }
}

void World::publishName(size_t name, int64_t step, std::vector<flow::Flow::Update>& updates) {
  updates.push_back({space_.names[name].name, space_.publish(space_.names[name], step)});
}

// Says which pinned generations are in the way.
bool World::hasRoom(uint64_t publisher) {
  bool has = true;
  for (const ObjectSpace::Name& name : space_.names) {
    std::optional<Id> wanted;
    if (name.publisher != publisher || space_.hasRoom(name, wanted)) continue;
    flow_.wanted(*wanted);
    has = false;
  }
  return has;
}

// The next step of a publisher, all of it or first a part of it. Publisher 0 is many: each name is its own.
void World::publish(uint64_t publisher, bool partly) {
  std::vector<flow::Flow::Update> updates;
  if (publisher == 0) {
    std::optional<Id> wanted;
    const size_t name = random_.below(space_.names.size());
    if (space_.names[name].publisher != 0) return;
    if (space_.hasRoom(space_.names[name], wanted))
      publishName(name, 0, updates);
    else
      flow_.wanted(*wanted);
  } else if (!due_.empty()) {
    std::optional<Id> wanted;
    const auto [name, step] = *due_.begin();
    if (!space_.hasRoom(space_.names[name], wanted)) return flow_.wanted(*wanted);
    publishName(name, step, updates);
    due_.erase(due_.begin());
  } else if (hasRoom(publisher)) {
    const int64_t step = ++steps_[publisher];
    for (size_t name = 0; name < space_.names.size(); name++) {
      if (space_.names[name].publisher != publisher) continue;
      if (partly && random_.oneIn(2))
        due_[name] = step;
      else
        publishName(name, step, updates);
    }
  }
  if (!updates.empty()) unsaid_.push_back(updates);
}

void World::announce() {
  if (unsaid_.empty()) return;
  flow_.update(unsaid_.front());
  unsaid_.pop_front();
}

void World::dropOrImport() {
  ObjectSpace::Name& name = space_.names[random_.below(space_.names.size())];
  while (!unsaid_.empty()) announce();
  if (!name.object.valid()) return;
  space_.drop(name);
  if (random_.oneIn(2) && name.publisher == 0) {  // another object takes the name at once
    std::vector<flow::Flow::Update> updates{{name.name, space_.publish(name, 0)}};
    flow_.update(updates);
  } else {
    flow_.dropped(name.name);
  }
}

void World::edit() {
  const bool live = random_.oneIn(2);
  if (live && random_.oneIn(2))
    drawn_->slide();
  else
    drawn_->edit();
  const uint64_t before = flow_.revision();
  const uint64_t revision = flow_.edit(drawn_->document(), live);
  if (revision == before) return;
  if (!live) recent_.clear();
  take(drawn_->document());
  std::erase_if(seen_, [&](const auto& item) { return !isDemanded(item.first); });
}

void World::changeDemand() {
  const std::string view = "v" + std::to_string(random_.below(3));
  const auto& nodes = flow_.document().nodes();
  const std::string& node = nodes[random_.below(nodes.size())].spec.name;
  switch (random_.below(24)) {
    case 0:
      paused_ = !paused_;
      paused_ ? flow_.pause() : flow_.resume();
      return;
    case 1:
      runAsked_ = true;
      broken_.clear();
      hasAsked_ = false;
      return flow_.run();
    case 2: {
      runAsked_ = hasAsked_ = true;
      const std::set<std::string> names = closure(flow_.document().document(), {node});
      std::erase_if(broken_, [&](const flow::NodeKey& key) {
        return std::any_of(nodes.begin(), nodes.end(), [&](const flow::Node& n) {
          return names.contains(n.spec.name) && n.spec.filter == truths_.at(key).filter &&
                 n.spec.properties == truths_.at(key).properties;
        });
      });
      return flow_.run(node);
    }
    case 3:
      hasAsked_ = true;
      return random_.oneIn(2) ? flow_.cancel() : flow_.cancel(node);
    case 4:
    case 5:
    case 6:
    case 7:
    case 8:
      windows_.erase(view);
      seen_.erase({TargetId::Kind::View, view});
      return flow_.hide(view);
    default:
      windows_[view] = !random_.oneIn(4);
      return flow_.show(view, windows_[view]);
  }
}

void World::answer() {
  if (random_.oneIn(8)) {  // an output is written
    for (auto& [id, seen] : seen_)
      if (id.kind == TargetId::Kind::Output && !seen.isHeld) {
        seen.isWritten = true;
        flow_.written(id.name, seen.what.wave);
      }
  } else if (random_.oneIn(12)) {
    flow_.makeRoom();
  } else if (random_.oneIn(12) && actions_.empty() && !outputs_.empty()) {
    const auto gone = std::next(outputs_.begin(), std::ptrdiff_t(random_.below(outputs_.size())));
    const flow::NodeKey key = *gone;
    for (const auto& [number, evaluation] : evaluations_)
      for (const auto& input : evaluation.what.inputs)
        for (const auto& item : input.items)
          if (item.data == flow::DataId(key)) return;
    outputs_.erase(gone);
    counters.evicted++;
    flow_.evicted(key);
  } else {
    answerEvaluation();
  }
}

// Whether the graph has cancelled it, and the host has not heard of that yet.
bool World::isToBeCancelled(uint64_t evaluation) const {
  return std::any_of(actions_.begin(), actions_.end(), [&](const flow::Action& action) {
    const auto* cancel = std::get_if<flow::CancelEvaluation>(&action);
    return cancel && cancel->evaluation == evaluation;
  });
}

void World::answerEvaluation() {
  if (evaluations_.empty()) return;
  const auto found = std::next(evaluations_.begin(), std::ptrdiff_t(random_.below(evaluations_.size())));
  const uint64_t number = found->first;
  const Evaluation evaluation = found->second;
  if (random_.oneIn(4)) return flow_.progress(number, 1, 2, "");
  evaluations_.erase(found);
  const flow::NodeKey& key = evaluation.what.key;
  const uint64_t luck = random_.below(evaluation.isCancelled ? 3 : 12);
  if (luck == 0) {
    broken_.insert(key);
    counters.failed++;
    flow_.failed(number, "it did not work", int(random_.below(4)));
  } else if (luck == 1) {
    if (!evaluation.isCancelled && !isToBeCancelled(number)) broken_.insert(key);
    flow_.cancelled(number);
  } else {
    expect(!broken_.contains(key), "an evaluation runs again that has failed");
    outputs_.insert(key);
    flow_.finished(number, {1, 0.5, 100});
  }
}

void World::answerAdoption() {
  for (auto& [number, hold] : holds_) {
    if (!hold.isAsked) continue;
    hold.isAsked = false;
    if (random_.oneIn(3)) {
      counters.refused++;
      return refuse(number, hold.id);
    }
    space_.adopt(hold.id);
    hold.isAdopted = true;
    counters.adopted++;
    return flow_.adopted(number);
  }
}

// Views of what is not to be kept let go of it, or show something newer.
void World::refuse(uint64_t hold, const Id& id) {
  std::set<TargetId> have;
  for (const auto& [target, seen] : seen_) {
    const bool isMadeAgain = runAsked_ && target.kind == TargetId::Kind::Output;  // it let go of all at once
    if (!actions_.empty() || isMadeAgain || !isDemanded(target) || seen.isHeld || seen.isWritten) continue;
    for (const flow::ShownData& item : seen.what.data)
      if (item.data == flow::DataId(id)) have.insert(target);
  }
  flow_.refused(hold, "no room");
  takeActions();
  for (const flow::Action& action : actions_) {
    if (const auto* held = std::get_if<flow::HoldPicture>(&action)) have.erase(held->target);
    if (const auto* shown = std::get_if<flow::ShowData>(&action)) have.erase(shown->target);
  }
  expect(have.empty(), "a view keeps what the ledger refuses");
}

void World::takeActions() {
  for (flow::Action& action : flow_.take()) actions_.push_back(std::move(action));
}

void World::carryOut(size_t most) {
  for (; most > 0 && !actions_.empty(); most--) {
    const flow::Action action = actions_.front();
    actions_.pop_front();
    carryOut(action);
    takeActions();
  }
}

void World::carryOut(const flow::Action& action) {
  if (const auto* a = std::get_if<flow::PinGeneration>(&action)) pin(*a);
  if (const auto* a = std::get_if<flow::StartEvaluation>(&action)) start(*a);
  if (const auto* a = std::get_if<flow::ShowData>(&action)) show(*a);
  if (const auto* a = std::get_if<flow::CancelEvaluation>(&action)) {
    counters.cancelled++;
    if (const auto found = evaluations_.find(a->evaluation); found != evaluations_.end())
      found->second.isCancelled = true;
  }
  if (const auto* a = std::get_if<flow::HoldPicture>(&action)) {
    counters.held++;
    if (const auto found = seen_.find(a->target); found != seen_.end()) found->second.isHeld = true;
  }
  if (const auto* a = std::get_if<flow::AdoptGeneration>(&action))
    if (const auto found = holds_.find(a->hold); found != holds_.end()) found->second.isAsked = true;
  if (const auto* a = std::get_if<flow::ReleaseGeneration>(&action)) {
    if (const auto found = holds_.find(a->hold); found != holds_.end()) {
      found->second.isAdopted ? space_.release(found->second.id) : space_.unpin(found->second.id);
      holds_.erase(found);
    }
  }
  if (const auto* a = std::get_if<flow::DropOutput>(&action)) {
    expect(outputs_.erase(a->key) == 1, "an output is dropped that is not there");
    for (const auto& [id, seen] : seen_)
      for (const flow::ShownData& item : seen.what.data)
        expect(seen.isHeld || seen.isWritten || item.data != flow::DataId(a->key),
               "an output is dropped that " + id.name + " shows");
  }
}

void World::pin(const flow::PinGeneration& action) {
  if (!space_.isThere(action.data)) {
    counters.lost++;
    lost_.insert(action.data);
    return flow_.lost(action.data);
  }
  space_.pin(action.data);
  expect(holds_.emplace(action.hold, Hold{action.data}).second, "a hold has a number that is in use");
}

void World::start(const flow::StartEvaluation& action) {
  counters.evaluations++;
  expect(evaluations_.size() < 2, "more than two evaluations run");
  expect(!outputs_.contains(action.key), "what is held is evaluated again");
  expect(!broken_.contains(action.key), "what has failed is tried again though nobody asked");
  for (const auto& [number, evaluation] : evaluations_)
    expect(evaluation.what.key != action.key, "one key is evaluated twice at once");
  Truth truth{action.filter, action.properties, {}, {}};
  for (const auto& input : action.inputs) {
    flow::KeyInput& made = truth.inputs.emplace_back();
    made.input = input.input;
    for (const auto& item : input.items) {
      made.data.push_back(item.data);
      if (const auto* id = std::get_if<Id>(&item.data))
        expect(space_.pins().contains(*id) || space_.adopted().contains(*id) || lost_.contains(*id),
               "an evaluation reads " + item.node + ", which is not pinned");
      else
        expect(outputs_.contains(std::get<flow::NodeKey>(item.data)),
               "an evaluation reads " + item.node + ", which is not there");
      const std::vector<Origin> origins = originsOf(item.data);
      expect(!flow::areMixed(truth.origins, origins), "an evaluation mixes steps");
      truth.origins = flow::joined(truth.origins, origins);
    }
  }
  expect(action.key == flow::keyOf(action.filter, action.version, action.properties, truth.inputs),
         "an evaluation has another key than what it reads");
  truths_[action.key] = truth;
  evaluations_[action.evaluation] = {action, false};
}

void World::show(const flow::ShowData& action) {
  if (!isDemanded(action.target)) return;  // hidden meanwhile
  counters.shown++;
  std::vector<Origin> origins;
  for (const flow::ShownData& item : action.data) {
    const std::vector<Origin> more = originsOf(item.data);
    expect(!flow::areMixed(origins, more), action.target.name + " mixes two steps");
    origins = flow::joined(origins, more);
    if (const auto* id = std::get_if<Id>(&item.data))
      expect(space_.pins().contains(*id) || space_.adopted().contains(*id) || lost_.contains(*id),
             action.target.name + " shows " + item.node + ", which is not pinned");
    else
      expect(outputs_.contains(std::get<flow::NodeKey>(item.data)) || counters.evicted > 0,
             action.target.name + " shows " + item.node + ", which is not there");
  }
  if (action.revision == flow_.revision()) checkWhole(action);
  seen_[action.target] = {action, false, false};
}

}  // namespace gxy::test
