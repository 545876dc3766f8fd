// SPDX-License-Identifier: Apache-2.0
// A graph of filters that is kept current: a document, the data that it is about, and who wants to see it.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/flow/actions.h"
#include "core/flow/document.h"
#include "core/flow/holds.h"
#include "core/flow/outcome.h"
#include "core/flow/outputs.h"
#include "core/flow/step.h"

namespace gxy::flow {

/// The state machine of one graph. It uses no sockets, threads, MPI or clock. The host tells it what happens, takes its actions and
/// carries them out in their order, but need not wait for one to be done: answers may come late and in any order. One thread at a time
/// may use a Flow. Errors (gxy::Error) come from wrong input of users alone, and change nothing.
///
/// A *wave* makes what views and outputs need, of one step of the sources: all of its nodes see the same generations, which stay pinned
/// as long as the wave or a view of its results needs them. One wave runs at a time. An edit supersedes it: what runs for keys that are
/// not needed any more is cancelled, and the new wave keeps the step of the old one where it can, so that what runs goes on. New data
/// wait until the wave has ended; the newest win. A view changes to a wave's results at once, when all that it shows is there.
class Flow {
 public:
  struct Options {
    uint64_t adoptAfter =
        10;  ///< ticks for which a publisher must want a generation before the graph adopts it
    size_t evaluations = 2;  ///< that run at once; those that are being cancelled count
  };

  /// `filters` must outlive it. There is no document yet, and nothing is needed.
  explicit Flow(const FilterSchemas& filters) : Flow(filters, Options()) {}
  Flow(const FilterSchemas& filters, Options options);

  // The document.

  /// Replaces the document, whole or not at all, and returns its revision: one more, or the same for an equal document. Throws Error as
  /// CompiledDocument does; then nothing has changed. `live`: more edits come, as of a slider that moves. Such an edit waits while
  /// the one before it is evaluated; the newest wins, and the last is always evaluated.
  uint64_t edit(const Document& document, bool live = false);
  uint64_t revision() const { return revision_; }
  const CompiledDocument& document() const { return *document_; }

  // Data. `name` is what the document calls, or may come to call, a source. Data of names that it does not have are remembered.

  struct Update {
    std::string name;
    SourceData data;
  };
  /// There are newer generations, or names mean other objects. What one publisher has published together must come together.
  void update(std::span<const Update> updates);
  void update(const std::string& name, const SourceData& data);
  /// The name means nothing any more. What views show stays until they show something else.
  void dropped(const std::string& name);
  /// The file of a source cannot be read.
  void sourceFailed(const std::string& name, const std::string& text, int rank = -1);
  /// The publisher wants the buffer of this generation back.
  void wanted(const SourceGeneration& generation);
  /// The generation could not be pinned; it is gone.
  void lost(const SourceGeneration& generation);

  // Demand.

  /// A window shows a view, or none does. A view that the document does not have yet, or not any more, may be shown. Without `follow`
  /// the view takes no newer data, whatever its document says; edits are evaluated nevertheless. Called again, changes that.
  void show(const std::string& view, bool follow = true);
  void hide(const std::string& view);
  /// Nothing new begins until resume(), but for what run() asks for.
  void pause();
  void resume();
  /// Evaluates all nodes once, or one with what it needs, with the newest data; tries again what has failed, and without a node makes all
  /// outputs again. What reads a source that is
  /// not there is left out. Throws Error for a node that the document does not have.
  void run();
  void run(const std::string& node);
  /// Cancels what runs or waits for its turn, or one node of it. It is not tried again until its key changes or somebody asks. Throws
  /// as run().
  void cancel();
  void cancel(const std::string& node);
  /// An output is made of what the ShowData of this wave gave; it needs these data no more.
  void written(const std::string& output, uint64_t wave);

  // Answers to actions. Those of which it knows nothing any more are ignored.

  void progress(uint64_t evaluation, double done, double of, const std::string& text);
  void finished(uint64_t evaluation, const Made& made);
  void failed(uint64_t evaluation, const std::string& text, int rank = -1);
  void cancelled(uint64_t evaluation);
  void adopted(uint64_t hold);
  /// The ledger refuses: views of this generation keep their last picture, and a wave keeps it pinned until it has ended.
  void refused(uint64_t hold, const std::string& text);
  /// Time passes.
  void tick(uint64_t ticks = 1);

  // Memory.

  /// Gives up the output that was used longest ago, of those that nothing needs: one DropOutput. Returns false if there is none.
  bool makeRoom();
  /// An output is gone. It is made again if it is needed.
  void evicted(const NodeKey& key);

  // What it asks for, and what it knows.

  /// Returns the actions since the last call. What is shown is pinned before, and released after.
  std::vector<Action> take();
  /// Returns the state of a node of the document; of another one, Waiting.
  NodeState state(const NodeId& node) const;
  bool isPaused() const { return paused_; }
  /// Whether something runs, or a wave has not ended.
  bool isBusy() const { return wave_ || !evaluations_.empty(); }

 private:
  struct Source {
    std::optional<SourceData> current;
    bool isTaken = false;    // a wave has seen the current generation
    bool isFetched = false;  // of a file: FetchSource was asked
    uint64_t leftOut = 0;
  };
  struct Evaluation {
    NodeKey key;
    std::string node;
    std::set<DataId> reads;
    std::vector<Origin> origins;
    bool isCancelled = false;
    double done = 0, of = 0;
    std::string text;
  };
  struct Wave {
    Wave(uint64_t n, uint64_t r, bool l, std::shared_ptr<NodeKeys> k)
        : number(n), revision(r), live(l), keys(std::move(k)) {}
    uint64_t number, revision;
    bool live;
    std::shared_ptr<NodeKeys> keys;
    Step step;
    std::map<TargetId, Target> targets;  // that have not all that they show
  };
  /// What a target shows.
  struct Shown {
    bool hasPicture = false, isHeld = false, isWritten = false;
    bool isAsked = false;  // somebody said run
    Picture picture;
    Step step;
    uint64_t wave = 0;
    std::string heldBecause;
    bool needs(const DataId& data) const;
  };
  /// What the unfinished part of a wave needs.
  struct Needs {
    std::vector<Outcome> outcomes;
    std::vector<std::optional<NodeKey>> keys;
    std::set<DataId> data;
    std::vector<size_t> pending;  // nodes to be evaluated, in order
  };

  // flow.cpp
  void resetChangedFiles(const CompiledDocument& newer);
  size_t placeOf(const std::string& node) const;
  void ask(const std::vector<Target>& targets);
  void cancelNodes(const std::optional<std::string>& node);
  void hold(const DataId& data, const std::string& text);
  // flow_waves.cpp
  void settle();
  std::vector<Target> demanded() const;
  bool isDemanded(const TargetId& id) const;
  bool isAllowed(const TargetId& id) const { return !paused_ || allowed_.contains(id); }
  void dropTargets();
  void forgetRuns();
  bool isMissingFile(size_t source) const;
  bool waitsForFile(const Target& target) const;
  bool beginWave(const Step& preferred);
  void joinWave();
  void addTarget(const Target& target, const Step& step);
  std::optional<Step> dueStep(const Target& target, const Step& preferred);
  std::optional<Step> stepFor(const Target& target, const Step& preferred, std::string& why) const;
  static bool showsAll(const Shown& shown, const Picture& picture);
  Picture pictureFor(const Target& target, const Step& step) const;
  std::vector<SourceData> candidates(const std::string& source) const;
  bool isAvailable(const SourceData& data) const;
  void showWhatIsThere();
  void rememberGood(const std::vector<Outcome>& outcomes);
  // flow_work.cpp
  void work();
  static std::vector<size_t> closureOf(const Wave& wave);
  Needs needsOf(const Wave& wave) const;
  void cancelNeedless();
  void startReady();
  void start(size_t place);
  void fetchSources();
  void holdWhatIsNeeded(std::vector<Action>& releases);
  // flow_states.cpp
  void tellStates();
  Step presentStep() const;
  Step newestData() const;
  NodeState stateOfSource(const Node& node) const;
  NodeState stateOfFilter(size_t place, const Outcome& outcome, const std::optional<NodeKey>& key) const;
  NodeState stateOfPending(size_t place, const std::optional<NodeKey>& key) const;
  NodeState stateOfTarget(const Target& target) const;
  const Evaluation* running(const Node& node, const std::optional<NodeKey>& key) const;
  void tell(const NodeId& id, const NodeState& state);

  const FilterSchemas& filters_;
  const Options options_;
  std::shared_ptr<const CompiledDocument> document_;
  std::shared_ptr<NodeKeys> keys_;
  uint64_t revision_ = 0;
  bool isLive_ = false;  // the newest edit

  std::map<std::string, Source> sources_;
  Holds holds_;
  Stock stock_;
  std::map<uint64_t, Evaluation> evaluations_;
  uint64_t nextEvaluation_ = 1;
  uint64_t now_ = 0;

  std::map<std::string, bool> windows_;  // views that are shown, and whether they follow
  bool paused_ = false;
  std::set<TargetId> allowed_;       // by run(), while paused
  std::map<TargetId, Target> runs_;  // asked for by run()

  std::optional<Wave> wave_;
  uint64_t waves_ = 0;
  uint64_t evaluatedRevision_ = 0;  // of the last wave that began
  Step preferred_;                  // that of the wave that an edit has superseded
  std::map<TargetId, Shown> shown_;
  std::map<TargetId, std::string> waiting_;  // targets that are due and cannot begin: why
  Needs needs_;                              // of the wave
  std::set<DataId> needed_;                  // by the wave and by what is shown
  std::set<NodeKey> kept_;                   // outputs that are needed or being read

  std::map<TargetId, Action> showing_;  // to be asked for once what is shown is pinned
  std::vector<Action> actions_;
  std::map<NodeId, NodeState> states_;
};

}  // namespace gxy::flow
