// SPDX-License-Identifier: Apache-2.0
// Names that data are published under, by imports and filters alike.
#include <algorithm>
#include <chrono>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/session.h"

namespace gxy {

using nlohmann::json;

namespace {

/// A name as it is taken: nobody shares a private one.
std::string keyOf(const std::string& tenant, Scope scope, const std::string& name) {
  return (scope == Scope::Shared ? "" : tenant) + "\n" + name;
}

}  // namespace

json Datasets::Names::items() const {
  json items = json::array();
  for (const DatasetDraft& d : drafts_)
    items.push_back({{"name", d.name}, {"key", d.key.value}, {"generation", d.generation}});
  return items;
}

void Datasets::Names::check() const {
  if (dropped_) throw Error("cancelled: a dataset of this " + operation_ + " was dropped");
  if (leaving_) throw Error(operation_ + ": an import or a filter makes one of its datasets now");
}

std::shared_ptr<const Datasets::Names> Datasets::begin(Request& request, uint64_t exchange,
                                                       const std::string& operation, Scope scope,
                                                       std::vector<DatasetDraft> drafts, bool onlyMissing) {
  const auto names = std::make_shared<Names>();
  names->operation_ = operation;
  names->tenant_ = request.session().tenant();
  names->scope_ = scope;
  names->exchange_ = exchange;
  names->drafts_ = std::move(drafts);
  notifyOnCancel(request);
  return begin(askerOf(request), names, onlyMissing);
}

std::shared_ptr<const Datasets::Names> Datasets::begin(const Asker& asker,
                                                       const std::shared_ptr<Names>& names,
                                                       bool onlyMissing) {
  const uint64_t exchange = names->exchange_;
  auto taken = takeNames(asker, names);
  serverRank_.exchanges.alsoCheck(exchange, [names] { names->check(); });
  if (onlyMissing)
    std::erase_if(names->drafts_, [&](const DatasetDraft& d) { return find(names->tenant_, d.name); });
  fillIn(*names);
  return taken;
}

std::shared_ptr<const Datasets::Names> Datasets::beginNow(const std::string& tenant, uint64_t exchange,
                                                          const std::string& operation, Scope scope,
                                                          std::vector<DatasetDraft> drafts) {
  const auto names = std::make_shared<Names>();
  names->operation_ = operation;
  names->tenant_ = tenant;
  names->scope_ = scope;
  names->exchange_ = exchange;
  names->givesWay_ = true;
  names->drafts_ = std::move(drafts);
  const std::set<std::string> keys = keysOf(*names);
  std::shared_ptr<const Names> taken;
  {
    const std::lock_guard lock(mutex_);
    const bool awaited = std::any_of(keys.begin(), keys.end(),
                                     [this](const std::string& key) { return awaited_.count(key) > 0; });
    if (awaited || !areFree(keys))
      throw Error(operation + ": an import or a filter makes one of its datasets now");
    taken = take(keys, names);
  }
  serverRank_.exchanges.alsoCheck(exchange, [names] { names->check(); });
  fillIn(*names);
  return taken;
}

void Datasets::fillIn(Names& names) const {
  for (DatasetDraft& d : names.drafts_) {
    const auto present = mayName(names.tenant_, d.name, names.scope_, names.ofGraph_);
    const bool isNext = present && present->type == nameOf(d.type);
    d.key = isNext ? present->key : serverRank_.keys.next();
    d.generation = isNext ? present->generation + 1 : 1;
  }
}

// The names as they are taken.
std::set<std::string> Datasets::keysOf(const Names& names) const {
  std::set<std::string> keys;
  for (const DatasetDraft& d : names.drafts_) {
    checkDatasetName(d.name);
    if (!keys.insert(keyOf(names.tenant_, names.scope_, d.name)).second)
      throw Error(names.operation_ + ": the name " + inQuotes(d.name) +
                  " is there twice, expected a name for each dataset");
  }
  return keys;
}

// With the lock held, as take().
bool Datasets::areFree(const std::set<std::string>& keys) const {
  return std::none_of(keys.begin(), keys.end(),
                      [this](const std::string& key) { return taken_.count(key) > 0; });
}

// The names are free again when what this returns goes.
std::shared_ptr<const Datasets::Names> Datasets::take(const std::set<std::string>& keys,
                                                      const std::shared_ptr<Names>& names) {
  for (const std::string& key : keys) taken_.emplace(key, names);
  publishing_.emplace(names->exchange_, names);
  return {names.get(), [this, keys, names](const Names*) {
            const std::lock_guard again(mutex_);
            for (const std::string& key : keys) taken_.erase(key);
            publishing_.erase(names->exchange_);
            changed_.notify_all();
          }};
}

void Datasets::askToLeave(const std::set<std::string>& keys) {
  std::vector<uint64_t> leaving;
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& key : keys)
      if (const auto at = taken_.find(key); at != taken_.end() && at->second->givesWay_) {
        at->second->leaving_ = true;
        leaving.push_back(at->second->exchange_);
      }
  }
  for (const uint64_t exchange : leaving) serverRank_.exchanges.cancel(exchange);
}

// So that who waits for names hears of it at once.
void Datasets::notifyOnCancel(Request& request) {
  request.onCancel([this] {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  });
}

std::shared_ptr<const Datasets::Names> Datasets::takeNames(const Asker& asker,
                                                           const std::shared_ptr<Names>& names) {
  const std::set<std::string> keys = keysOf(*names);
  {
    const std::lock_guard lock(mutex_);
    awaited_.insert(keys.begin(), keys.end());  // so that nobody who gives way takes them meanwhile
  }
  const std::shared_ptr<void> forget(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    for (const std::string& key : keys) awaited_.erase(awaited_.find(key));
  });
  askToLeave(keys);
  for (;;) {
    asker.check();
    std::unique_lock lock(mutex_);
    if (areFree(keys)) return take(keys, names);
    changed_.wait_for(lock, std::chrono::milliseconds(100));
  }
}

bool Datasets::endPublishingOf(const std::string& tenant, const std::string& name) {
  std::vector<uint64_t> ended;
  {
    const std::lock_guard lock(mutex_);
    for (const Scope scope : {Scope::Private, Scope::Shared})
      if (const auto at = taken_.find(keyOf(tenant, scope, name));
          at != taken_.end() && at->second->tenant_ == tenant) {
        at->second->dropped_ = true;
        ended.push_back(at->second->exchange_);
      }
  }
  for (const uint64_t exchange : ended) serverRank_.exchanges.cancel(exchange);
  return !ended.empty();
}

std::vector<Datasets::NewObject> Datasets::newObjects(const Names& names) const {
  names.check();
  std::vector<NewObject> objects;
  for (const DatasetDraft& d : names.drafts_) {
    auto now = mayName(names.tenant_, d.name, names.scope_, names.ofGraph_);
    if (d.generation > 1) {
      if (!now || now->key != d.key)
        throw Error(
            names.operation_ + ": " + inQuotes(d.name) +
            " was dropped, renamed or taken back meanwhile, expected the dataset that was there at first");
      continue;
    }
    NamedDataset dataset{
        d.key, d.name,        names.scope_, nameOf(d.type), names.tenant_, names.scope_ == Scope::Shared,
        1,     names.ofGraph_};
    if (now) {
      dataset.owner = now->owner;  // who has published it for all to write
      dataset.readOnly = now->readOnly;
    }
    objects.push_back({std::move(dataset), std::move(now)});
  }
  return objects;
}

Publication Datasets::join(const json& items, Collectives& ranks) {
  // New objects keep this wait for their later updates: whoever shows the generation before the current one
  // lets go of it soon (docs/protocol.md section 9.2, Updates).
  constexpr WhenTaken whenTaken{std::chrono::seconds(1)};
  std::vector<Publication::Item> list;
  for (const json& item : items)
    list.push_back({Key{item.at("key").get<uint64_t>()}, item.at("generation").get<Generation>(),
                    "dataset " + inQuotes(item.at("name").get<std::string>())});
  return {serverRank_.objects, ranks, std::move(list), whenTaken};
}

std::shared_ptr<const Datasets::Names> Datasets::namesOf(uint64_t exchange) const {
  const std::lock_guard lock(mutex_);
  return publishing_.at(exchange);
}

void Datasets::publish(Publication& publication, uint64_t exchange) {
  if (serverRank_.rank() != 0) return publication.commit();
  std::vector<NewObject> objects;
  std::unique_lock naming(naming_, std::defer_lock);
  publication.commit(
      {[&] {
         naming.lock();
         objects = newObjects(*namesOf(exchange));
       },
       [&] {
         for (const auto& [d, replaced] : objects)
           serverRank_.directory.bind(d.name, d.scope, {d.key, d.type, d.owner, d.readOnly, d.ofGraph});
       }});
  for (const auto& [d, replaced] : objects) {
    const std::lock_guard lock(mutex_);
    names_[d.key] = {d.name, d.scope};
    newest_[d.owner].push_back(d.key);
  }
  for (const auto& [d, replaced] : objects)
    if (replaced) tell({DatasetEvent::Kind::Dropped, *replaced, {}, {}});
  for (const auto& [d, replaced] : objects) tell({DatasetEvent::Kind::Added, d, {}, originOf(d.key)});
  naming.unlock();
  for (const auto& [d, replaced] : objects)
    if (replaced) dropObject(replaced->key);
}

}  // namespace gxy
