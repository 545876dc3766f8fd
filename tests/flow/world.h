// SPDX-License-Identifier: Apache-2.0
// A host of one Flow that does what it asks for late and in any order, and checks each action against what it knows itself.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/flow/flow.h"
#include "tests/flow/object_space.h"
#include "tests/flow/random_document.h"

namespace gxy::test {

/// One seeded schedule. Every check that fails is a line of `errors`.
class World {
 public:
  explicit World(uint64_t seed);

  void run(int events);
  /// The host answers everything, and nothing new happens. Then checks that everything is as it has to be at rest.
  void rest();
  /// Nobody looks any more: nothing is held.
  void leave();

  std::vector<std::string> errors;
  struct Counters {
    int64_t evaluations = 0, shown = 0, cancelled = 0, failed = 0, adopted = 0, refused = 0, held = 0,
            lost = 0, evicted = 0, leftOut = 0, missing = 0;
  };
  Counters counters;

 private:
  using Id = flow::SourceGeneration;
  struct Hold {
    Id id;
    bool isAdopted = false, isAsked = false;
  };
  struct Evaluation {
    flow::StartEvaluation what;
    bool isCancelled = false;
  };
  /// What an output was made of.
  struct Truth {
    std::string filter, properties;
    std::vector<flow::KeyInput> inputs;
    std::vector<Origin> origins;
  };
  struct Seen {
    flow::ShowData what;
    bool isHeld = false, isWritten = false;
  };

  void take(const flow::Document& document) {
    recent_.push_back(std::make_shared<const flow::CompiledDocument>(document, filters_));
  }
  const flow::Document& newestDocument() const { return recent_.back()->document(); }
  void expect(bool holds, const std::string& what) {
    if (!holds && errors.size() < 20) errors.push_back(what);
  }

  // world.cpp: what happens
  void event();
  void publish(uint64_t publisher, bool partly);
  void publishName(size_t name, int64_t step, std::vector<flow::Flow::Update>& updates);
  bool hasRoom(uint64_t publisher);
  void announce();
  void dropOrImport();
  void edit();
  void changeDemand();
  void answer();
  bool isToBeCancelled(uint64_t evaluation) const;
  void answerEvaluation();
  void answerAdoption();
  void refuse(uint64_t hold, const Id& id);
  void takeActions();
  void carryOut(size_t most);
  void carryOut(const flow::Action& action);
  void pin(const flow::PinGeneration& action);
  void start(const flow::StartEvaluation& action);
  void show(const flow::ShowData& action);

  // world_checks.cpp: what has to hold
  void checkWhole(const flow::ShowData& action);
  void checkQuiet();
  void checkPins();
  void checkNeeded(const Evaluation& evaluation);
  bool isDemanded(const flow::TargetId& id) const;
  bool isFollowed(const flow::TargetId& id) const;
  std::set<std::string> closure(const flow::Document& document, const std::vector<std::string>& shown) const;
  std::vector<std::string> shownBy(const flow::Document& document, const flow::TargetId& id) const;
  std::string stateOf(const flow::TargetId& id, const std::string& name) const;
  void checkTarget(const flow::TargetId& id, bool follows);
  bool matches(const flow::CompiledDocument& document, const std::string& node,
               const flow::DataId& data) const;
  struct Newest {
    std::optional<flow::DataId> data;  // none: a source is not there, or the node cannot be evaluated
    std::string brokenBy;              // a node that has failed or cannot be evaluated
  };
  Newest newest(const flow::CompiledDocument& document, const std::string& node) const;
  std::vector<Origin> originsOf(const flow::DataId& data) const;

  Random random_;
  FewFilters filters_;
  ObjectSpace space_;
  std::optional<RandomDocument> drawn_;
  flow::Flow flow_;
  std::vector<std::shared_ptr<const flow::CompiledDocument>> recent_;  // a live wave may be of an older one
  bool paused_ = false;
  bool runAsked_ = false;  // since the graph was idle last
  bool hasAsked_ =
      false;  // it is not known here of which nodes the failures are forgotten, or made by cancelling
  std::map<std::string, bool> windows_;  // views that are shown, and whether they follow
  std::map<uint64_t, int64_t> steps_;    // of publishers
  std::map<size_t, int64_t> due_;        // names that have to publish the step that others have published
  std::deque<std::vector<flow::Flow::Update>> unsaid_;
  std::set<Id> lost_;

  std::deque<flow::Action> actions_;
  std::map<uint64_t, Hold> holds_;
  std::map<uint64_t, Evaluation> evaluations_;
  std::set<flow::NodeKey> outputs_, broken_;
  std::map<flow::NodeKey, Truth> truths_;
  std::map<flow::TargetId, Seen> seen_;
};

}  // namespace gxy::test
