// SPDX-License-Identifier: Apache-2.0
// One graph of a tenant: its document, its evaluation, and who watches. Rank 0.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/flow/flow.h"
#include "multiserver/graph/graph_document.h"
#include "multiserver/graph/graph_services.h"
#include "multiserver/graph/marked_edits.h"
#include "multiserver/rendering/scene_cache.h"
#include "multiserver/server/filter_runs.h"
#include "multiserver/server/outbox.h"

namespace gxy {

/// What a window on a view shows.
struct ViewContent {
  uint64_t serial = 0;                         ///< ascends with every change
  uint64_t revision = 0;                       ///< of the document
  std::optional<Visualization> visualization;  ///< of the operators whose data are there; none: see `text`
  SceneCache::GivenData data;                  ///< of these operators
  RenderSettings settings;
  std::optional<Camera> camera;
  std::optional<glm::ivec2> size;
  std::string text;  ///< why nothing can be rendered
};

/// The host of a flow::Flow (core/flow/flow.h): it carries out what the Flow asks for, with the ranks, and tells it what happens. Thread
/// safe. Functions throw Error for what users say, and after end().
class Graph : public std::enable_shared_from_this<Graph> {
 public:
  /// `services` must outlive it.
  Graph(GraphServices& services, std::string tenant, std::string name);
  ~Graph();
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  const std::string& tenant() const { return tenant_; }
  const std::string& name() const { return name_; }

  /// Who makes an edit, or watches.
  struct Client {
    uint64_t session = 0;
    std::string name;
    nlohmann::json json() const { return {{"session", session}, {"client", name}}; }
  };
  /// Replaces the document. Returns warnings.
  std::vector<std::string> setDocument(const nlohmann::json& document, const StateReader& readState);
  /// Applies edits (document_edits.h), all or none. Returns `revision`, `inverse` and `warnings`; of edits that were applied before, by
  /// `mark`, their `revision` and `repeated`.
  nlohmann::json edit(const nlohmann::json& edits, bool live, const std::optional<EditMark>& mark,
                      const Client& by, const StateReader& readState);
  /// Returns `document`, `revision`, `paused` and `nodes`.
  nlohmann::json describe() const;
  /// Returns what a node's filter has told of its generations from this one on: at most the newest 10,000 of the filter and its
  /// properties as they are now, in at most 4 MiB. Throws Error for a node that the document does not have.
  nlohmann::json numbers(const std::string& node, Generation from) const;
  /// Returns `graph`, `revision`, `nodes` (their number), `clients` and `paused`.
  nlohmann::json summary() const;

  /// Tells this session of edits and states from now on.
  void watch(const Client& client, const std::shared_ptr<Outbox>& outbox);
  void unwatch(uint64_t session);

  void run(const std::optional<std::string>& node);
  void cancel(const std::optional<std::string>& node);
  void pause();
  void resume();
  /// Waits until nothing runs, no wave is under way, and outputs are made. `check` is called about every 50 ms, and may throw. Returns false if it takes
  /// longer than this.
  bool waitUntilIdle(std::chrono::duration<double> patience, const std::function<void()>& check);

  /// A window shows a view from now on; `changed` is called on a thread that may wait, when content() may be another. Returns its number.
  uint64_t show(const std::string& view, std::function<void()> changed);
  /// Whether the window wants newer data, as it does at first. A view takes newer data while one of its windows wants them.
  void setFollow(uint64_t window, bool follow);
  /// The window has gone. If it was the view's last, what runs now goes on nevertheless, for ServerRankOptions::leftViewsFor at most.
  void hide(uint64_t window);
  /// What a window shows, or one on a view would. A window goes with its view where that is renamed.
  ViewContent content(uint64_t window) const;
  ViewContent content(const std::string& view) const;

  /// Data of this name may be others.
  void onData();
  void onWanted(const flow::SourceGeneration& generation);
  /// There is no such object any more.
  void onDropped(Key object);
  /// Returns whether it is to be called again.
  bool tick();

  /// Ends all that runs, waits for it, and gives up all that it holds.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  struct Running {
    explicit Running(std::string n) : node(std::move(n)) {}
    const std::string node;  ///< or output
    std::atomic<bool> isCancelled = false;
    std::atomic<uint64_t> exchange = 0;
  };
  struct ShownItem {
    std::string node;
    flow::DataId data;
    std::shared_ptr<const KeptData> kept;
  };
  struct Shown {
    std::vector<ShownItem> items;
    std::string text;  ///< why there is nothing, or the picture is held
    bool isHeld = false;
    std::string failure;  ///< why no picture can show all of it; empty: one can
  };
  struct Fetched {
    DatasetSpec spec;
    bool isUnderWay = true;
    std::shared_ptr<Running> running;
  };
  /// An output that is being made.
  struct OutputJob {
    OutputSpec what;
    uint64_t wave = 0;
    std::vector<ShownItem> items;
    // Of pictures:
    std::optional<ViewLook> look;
    RenderSettings settings;
    std::map<std::string, glm::dvec4> colors;  ///< of geometry, by dataset
  };
  /// An output that is made now.
  struct Writing {
    OutputSpec what;
    std::shared_ptr<Running> running;
  };
  /// What has become of an output last.
  struct Written {
    OutputSpec what;
    std::string file, error;
    int rank = -1;
  };
  struct Published {
    OutputSpec what;
    std::shared_ptr<const GraphOutput> output;  ///< which stays as long as it has the name
  };
  /// Why something failed, and on which rank.
  struct Failure {
    std::string text;
    int rank = -1;
  };
  /// What a filter has told of its generations.
  struct Series {
    DatasetSpec spec;
    std::deque<nlohmann::json> entries;
    size_t bytes = 0;
    LedgerEntry memory;
  };
  /// The newest step and the time of what an evaluation reads; NaN: unknown.
  struct StepAndTime {
    int64_t step = 0;
    double time = std::numeric_limits<double>::quiet_NaN();
  };
  struct Watcher {
    Client client;
    std::shared_ptr<Outbox> outbox;
  };
  struct Told {
    Clock::time_point at{};
    nlohmann::json state;
    bool isDue = false;
  };

  // graph.cpp: what it is told
  void checkNotEnded() const;
  LedgerEntry roomFor(const GraphDocument& document);
  StateReader withRoom(const StateReader& readState);
  void commit(GraphDocument document, LedgerEntry memory, bool live, const nlohmann::json& event,
              const std::vector<std::pair<std::string, std::string>>& renamedViews = {});
  void dropWhatTheDocumentHasNot();
  void dropImported(const std::string& source);
  void lookAtData();
  void wantNews();
  void post(std::function<void()> task);
  bool isLookPosted() const;
  void postUnlessEnding(std::function<void()> task);
  ViewContent contentOf(const std::string& view) const;
  void follow(const std::pair<std::string, std::string>& renamedView);
  bool isFollowed(const std::string& view) const;
  void leave(const std::string& view);
  void forgetLeft();
  void viewsChanged();
  void release();

  // graph_actions.cpp: what the Flow asks for
  void act();
  void couldNot(const flow::Action& action, const std::string& text);
  void carryOut(const flow::PinGeneration& action);
  void carryOut(const flow::AdoptGeneration& action);
  void carryOut(const flow::ReleaseGeneration& action);
  void carryOut(const flow::FetchSource& action);
  void carryOut(const flow::StartEvaluation& action);
  void carryOut(const flow::CancelEvaluation& action);
  void carryOut(const flow::DropOutput& action);
  void carryOut(const flow::ShowData& action);
  void carryOut(const flow::HoldPicture& action);
  void carryOut(const flow::ChangeState& action);
  void adopt(uint64_t hold, const std::shared_ptr<KeptData>& kept);
  void fetch(const DatasetSpec& spec, const std::shared_ptr<Running>& running);
  void evaluate(const flow::StartEvaluation& action, const std::shared_ptr<Running>& running);
  bool giveUpOldest();
  void dropUnused(const std::map<flow::NodeKey, std::shared_ptr<const GraphOutput>>& outputs);
  void giveName(const std::string& node, const flow::NodeKey& key);
  std::vector<FilterRuns::Evaluation::Source> sourcesOf(const flow::StartEvaluation& action) const;
  Asker askerFor(uint64_t evaluation, const std::shared_ptr<Running>& running);
  std::shared_ptr<KeptData> keptSource(const flow::SourceGeneration& id) const;
  void stop(Running& running);
  std::function<void(uint64_t exchange)> begunOf(const std::shared_ptr<Running>& running);

  static Failure failureOf(const std::string& text);
  std::vector<ShownItem> itemsOf(const flow::ShowData& action, const std::vector<ShownItem>& known) const;
  std::string failureOf(const std::vector<ShownItem>& items) const;

  // graph_outputs.cpp: what it makes of data beside showing them
  void carryOut(const flow::ShowData& action, std::vector<ShownItem> items);
  void stopOutput(const std::string& name);
  void startOutputs();
  void dropOutputsThatTheDocumentHasNot();
  bool isBusy() const { return flow_.isBusy() || !writing_.empty(); }
  void makeOutput(const OutputJob& job, const std::shared_ptr<Running>& running);
  std::string pathOf(const OutputJob& job) const;
  std::string writeDataFile(const OutputJob& job, const std::shared_ptr<Running>& running);
  std::string writePicture(const OutputJob& job, const std::shared_ptr<Running>& running);
  void publish(const OutputJob& job);
  void unpublish(bool all);
  static Asker askerOf(const Running& running);
  static SceneCache::GivenData givenTo(Visualization& visualization, const std::vector<ShownItem>& items,
                                       const std::map<std::string, glm::dvec4>& colors);

  // graph_events.cpp: what it tells
  nlohmann::json nodesJson() const;
  nlohmann::json stateJson(const flow::NodeId& node) const;
  void addOutcome(const std::string& output, nlohmann::json& state) const;
  void tellNode(const flow::NodeId& node);
  void keepTold(const std::string& node, const GraphOutput& output, const StepAndTime& at);
  void send(const nlohmann::json& event);
  void sendPresent();

  GraphServices& services_;
  const std::string tenant_, name_;

  std::mutex editing_;  ///< held while a document is read and committed; before mutex_
  MarkedEdits marked_;  ///< changed while editing_ is held
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  flow::Flow flow_;
  GraphDocument document_;
  LedgerEntry documentMemory_;
  uint64_t revision_ = 0;
  bool isEnded_ = false;

  // Observers of data call the graph while others, also other graphs, hold their locks. So they take only this lock, after mutex_.
  mutable std::mutex tasksMutex_;
  std::condition_variable tasksEnded_;
  size_t tasks_ = 0;  ///< posted ones that have not ended
  bool lookIsPosted_ = false, takesNoTasks_ = false;

  std::set<std::string> there_;  ///< live sources of which there are data
  std::map<uint64_t, std::shared_ptr<KeptData>> holds_;
  std::map<uint64_t, flow::SourceGeneration> heldIds_;
  std::set<flow::SourceGeneration> wanted_;  ///< by publishers, of what is pinned
  std::map<flow::NodeKey, std::shared_ptr<const GraphOutput>> outputs_;
  std::map<std::string, std::pair<flow::NodeKey, Key>> named_;  ///< the outputs that have names, by node
  std::map<std::string, Generation> generations_;               ///< that were made, by node
  std::map<uint64_t, std::shared_ptr<Running>> running_;        ///< evaluations
  std::map<std::string, Fetched> fetched_;                      ///< by source
  std::map<std::string, std::set<Key>> imported_;               ///< objects that files have become, by source
  std::shared_ptr<void> wish_;                                  ///< for newer data

  uint64_t serial_ = 0, nextWindow_ = 1;
  struct ViewWindow {
    std::function<void()> changed;
    bool follow = true;
  };
  std::map<std::string, std::map<uint64_t, ViewWindow>> windows_;  ///< by view
  std::map<uint64_t, std::string> viewOf_;                         ///< by window
  std::map<std::string, Clock::time_point>
      left_;                            ///< views without a window, and until when what runs for them goes on
  std::map<std::string, Shown> shown_;  ///< by view
  std::map<std::string, Series> series_;        ///< by node
  std::map<std::string, Writing> writing_;      ///< outputs that are being made
  std::map<std::string, OutputJob> due_;        ///< outputs that are to be made next
  std::map<std::string, Written> written_;      ///< outputs that were made, or could not be
  std::map<std::string, Published> published_;  ///< by output
  std::map<uint64_t, Watcher> watchers_;        ///< by session
  std::map<flow::NodeId, Told> told_;
};

}  // namespace gxy
