// SPDX-License-Identifier: Apache-2.0
// The graphs of all tenants.
#pragma once
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "multiserver/graph/graph.h"
#include "multiserver/server/module.h"

namespace gxy {

/// A window on a view of a graph, as long as it lives.
class GraphView {
 public:
  /// `changed` is called on a thread that may wait, when content() may be another. It must not keep the view alive.
  GraphView(std::shared_ptr<Graph> graph, const std::string& view, std::function<void()> changed)
      : graph_(std::move(graph)), window_(graph_->show(view, std::move(changed))) {}
  ~GraphView() { graph_->hide(window_); }
  GraphView(const GraphView&) = delete;
  GraphView& operator=(const GraphView&) = delete;

  ViewContent content() const { return graph_->content(window_); }
  /// Whether the window wants newer data, as it does at first.
  void setFollow(bool follow) { graph_->setFollow(window_, follow); }

 private:
  const std::shared_ptr<Graph> graph_;
  const uint64_t window_;
};

/// There is one on each rank; all but the constructor is for rank 0. Thread safe.
class Graphs {
 public:
  static constexpr size_t kOfTenant = 256;  ///< graphs of one tenant at a time

  explicit Graphs(Registration& registration);
  ~Graphs();

  /// Makes a graph. Returns it with warnings about its document. Throws Error for a name that is in use or no name of a graph, and for a
  /// document that is wrong; then there is none.
  std::pair<std::shared_ptr<Graph>, std::vector<std::string>> make(const std::string& tenant,
                                                                   const std::string& name,
                                                                   const nlohmann::json& document,
                                                                   const StateReader& readState);
  enum class Access { Look, Change };
  /// Returns the tenant's graph of this name, else the one that another tenant has published. Throws Error if there is none, and, to change
  /// it, if it was published to be looked at only.
  std::shared_ptr<Graph> get(const std::string& tenant, const std::string& name,
                             Access access = Access::Look) const;
  struct Listed {
    std::shared_ptr<Graph> graph;
    std::optional<Access> shared;  ///< what all tenants may do, if it was published
  };
  /// Returns the tenant's graphs, and then those that others have published.
  std::vector<Listed> list(const std::string& tenant) const;
  /// Lets all tenants look at a graph of the tenant, or change it; again, with another access. Throws Error if there is none, or another
  /// tenant has published one of this name.
  void publish(const std::string& tenant, const std::string& name, Access access);
  /// Takes that back. Windows of other tenants that show it go on with it until they show something else.
  void unpublish(const std::string& tenant, const std::string& name);
  /// Ends a graph of the tenant and waits. Throws Error if there is none.
  void drop(const std::string& tenant, const std::string& name);

 private:
  std::shared_ptr<Graph> own(const std::string& tenant, const std::string& name) const;
  std::vector<std::shared_ptr<Graph>> all() const;
  void onDataset(const DatasetEvent& event);
  void runClock();
  void wake();
  void end();

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  GraphServices services_;
  std::map<std::string, std::map<std::string, std::shared_ptr<Graph>>> graphs_;  ///< by tenant and name
  struct Shared {
    std::shared_ptr<Graph> graph;
    Access access = Access::Look;
  };
  std::map<std::string, Shared> shared_;  ///< by name
  bool isEnding_ = false;
  bool isAwake_ = false;
  std::thread clock_;  ///< from the first graph on
  std::shared_ptr<void> datasets_;
  Observers::Subscription objects_;
};

/// Returns the rank's Graphs. Called in a module's body, on every rank. The first module that calls it registers the works.
std::shared_ptr<Graphs> graphsOf(Registration& registration);

/// Throws Error unless it is a name for a graph: 1 to 100 bytes of text without control characters and `/`.
void checkGraphName(const std::string& name);

}  // namespace gxy
