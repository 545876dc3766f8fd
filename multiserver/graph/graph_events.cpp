// SPDX-License-Identifier: Apache-2.0
// What clients are told of a graph.
#include <cmath>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "multiserver/graph/graph.h"
#include "multiserver/protocol/json.h"

namespace gxy {

using flow::NodeId;
using flow::NodeState;
using nlohmann::json;

namespace {

constexpr std::chrono::milliseconds kBetweenEvents{100};  // of one node

const char* nameOf(NodeState::Kind kind) {
  constexpr const char* names[] = {"incomplete", "blocked", "waiting", "queued",
                                   "running",    "done",    "stale",   "failed"};
  return names[size_t(kind)];
}

const char* nameOf(NodeId::Kind kind) {
  constexpr const char* names[] = {"dataset", "view", "output"};
  return names[size_t(kind)];
}

json jsonOf(const NodeState& state) {
  json out{{"state", nameOf(state.kind)}};
  if (!state.text.empty()) out["text"] = state.text;
  if (!state.by.empty()) out["by"] = state.by;
  if (state.rank >= 0) out["rank"] = state.rank;
  if (state.kind == NodeState::Kind::Running && state.of > 0)
    out.update({{"done", state.done}, {"of", state.of}});
  if (state.kind == NodeState::Kind::Done && state.generation > 0) {
    out["generation"] = state.generation;
    if (state.output) out.update({{"seconds", state.seconds}, {"bytes", state.bytes}});
  }
  if (state.leftOut > 0) out["left out"] = state.leftOut;
  if (state.showsOlder) out["shows older"] = true;
  return out;
}

}  // namespace

json Graph::stateJson(const NodeId& node) const {
  const NodeState state = flow_.state(node);
  json out = jsonOf(state);
  out.update({{"node", node.name}, {"kind", nameOf(node.kind)}});
  if (state.output)
    if (const auto found = outputs_.find(*state.output);
        found != outputs_.end() && !found->second->told.empty())
      out["told"] = found->second->told;
  if (node.kind == NodeId::Kind::Output) addOutcome(node.name, out);
  if (node.kind != NodeId::Kind::View) return out;
  const auto look = document_.looks.find(node.name);
  if (look != document_.looks.end() && !look->second.missing.empty())
    out.update({{"state", "incomplete"}, {"text", look->second.missing}});
  else if (const auto shown = shown_.find(node.name);
           shown != shown_.end() && !shown->second.failure.empty() && state.kind == NodeState::Kind::Done)
    out.update({{"state", nameOf(NodeState::Kind::Failed)}, {"text", shown->second.failure}});
  return out;
}

/// Adds what is known of the making of an output.
void Graph::addOutcome(const std::string& output, json& state) const {
  const auto known = written_.find(output);
  if (writing_.contains(output)) {
    state["state"] = nameOf(NodeState::Kind::Running);
  } else if (known != written_.end() && !known->second.error.empty()) {
    state.update({{"state", nameOf(NodeState::Kind::Failed)}, {"text", known->second.error}});
    if (known->second.rank >= 0) state["rank"] = known->second.rank;
  }
  if (known != written_.end() && !known->second.file.empty()) state["file"] = known->second.file;
}

json Graph::nodesJson() const {
  json nodes = json::array();
  for (const DatasetSpec& d : document_.flow.datasets)
    nodes.push_back(stateJson({NodeId::Kind::Dataset, d.name}));
  for (const flow::ViewSpec& v : document_.flow.views)
    nodes.push_back(stateJson({NodeId::Kind::View, v.name}));
  for (const auto& [name, output] : document_.outputs)
    nodes.push_back(stateJson({NodeId::Kind::Output, name}));
  return nodes;
}

void Graph::keepTold(const std::string& node, const GraphOutput& output, const StepAndTime& at) {
  constexpr size_t kMost = 10000, kMostBytes = 4 << 20, kRoom = 64 << 10;
  const DatasetSpec* spec = document_.dataset(node);
  if (!spec || output.told.empty()) return;
  json entry = output.told;
  entry["generation"] = output.made.generation;
  entry["step"] = at.step;
  if (!std::isnan(at.time)) entry["time"] = at.time;
  Series& series = series_[node];
  if (series.entries.empty()) series.spec = *spec;
  const auto bytesOf = [](const json& e) { return protocol::dump(e).size(); };
  const auto forgetOldest = [&] {
    series.bytes -= bytesOf(series.entries.front());
    series.entries.pop_front();
  };
  series.bytes += bytesOf(entry);
  series.entries.push_back(std::move(entry));
  while (series.entries.size() > kMost || series.bytes > kMostBytes) forgetOldest();
  if (int64_t(series.bytes) <= series.memory.bytes()) return;
  try {
    series.memory = services_.serverRank.takeMemory(tenant_, "graph " + name_ + "/" + node,
                                                    int64_t((series.bytes / kRoom + 1) * kRoom));
  } catch (const Error&) {
    while (int64_t(series.bytes) > series.memory.bytes()) forgetOldest();
  }
}

json Graph::numbers(const std::string& node, Generation from) const {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  if (!document_.dataset(node)) throw Error("numbers: there is no dataset " + inQuotes(node));
  json out = json::array();
  if (const auto found = series_.find(node); found != series_.end())
    for (const json& entry : found->second.entries)
      if (entry.at("generation").get<Generation>() >= from) out.push_back(entry);
  return out;
}

void Graph::tellNode(const NodeId& node) {
  Told& told = told_[node];
  const auto now = Clock::now();
  told.isDue = now < told.at + kBetweenEvents;
  if (told.isDue) return services_.wake();
  json state = stateJson(node);
  if (state == told.state) return;
  told.at = now;
  told.state = state;
  state.update({{"event", "node"}, {"graph", name_}});
  send(state);
}

void Graph::send(const json& event) {
  for (const auto& [session, watcher] : watchers_) watcher.outbox->event(event);
}

void Graph::sendPresent() {
  json clients = json::array();
  for (const auto& [session, watcher] : watchers_) clients.push_back(watcher.client.json());
  send({{"event", "present"}, {"graph", name_}, {"clients", clients}});
}

bool Graph::tick() {
  const std::lock_guard lock(mutex_);
  if (isEnded_) return false;
  bool again = false;
  if (!wanted_.empty()) {
    flow_.tick();
    again = true;
  }
  act();
  again = again || !left_.empty();
  std::vector<NodeId> due;
  for (const auto& [node, told] : told_)
    if (told.isDue) due.push_back(node);
  for (const NodeId& node : due) {
    tellNode(node);
    again = again || told_[node].isDue;
  }
  return again;
}

}  // namespace gxy
