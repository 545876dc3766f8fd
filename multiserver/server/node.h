// SPDX-License-Identifier: Apache-2.0
// One rank of the server: all that modules work with.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/comm/collective.h"
#include "core/comm/presence.h"
#include "core/comm/work.h"
#include "core/io/collectives.h"
#include "core/rays/backend.h"
#include "core/render/renderer.h"
#include "core/space/directory.h"
#include "core/space/ledger.h"
#include "core/space/objects.h"
#include "multiserver/server/data_folders.h"
#include "multiserver/server/document_reader.h"
#include "multiserver/server/exchanges.h"
#include "multiserver/server/tenants.h"

namespace gxy {

class Datasets;
class Modules;

struct NodeOptions {
  std::vector<std::string> dataFolders;    ///< none: the current one
  std::vector<std::string> moduleFolders;  ///< looked into in this order; none: there are no modules
  std::string backend = "auto";
  int64_t memory = int64_t(8) << 30;        ///< bytes of all tenants, on each rank
  int64_t tenantMemory = int64_t(8) << 30;  ///< of one
  int tenantFrames = 64;                    ///< renderings in flight of one tenant
  /// For which a picture that is not yet there may keep data of another tenant from being updated.
  std::chrono::milliseconds longestHold{10000};
  std::chrono::milliseconds rankPatience{
      10000};                      ///< a rank that has not answered for so long is said to be missing
  int threads = 2;                 ///< of each rank, that run its tasks
  int64_t raysInFlight = 1 << 20;  ///< of each rank
  Trace* trace = nullptr;          ///< of requests, works and rendering, if not null; outlives the node
};

/// Made on every rank at the same time, over its Transport, and destroyed on all ranks together. Threads: its parts are
/// thread safe each. The order of the members is that of their dependencies.
struct Node {
  /// Throws Error, possibly on this rank only, for options that cannot be met.
  Node(Transport& transport, NodeOptions options, const BackendRegistry& backends);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  int rank() const { return transport.rank(); }
  int ranks() const { return transport.size(); }

  /// A number that names one exchange of all ranks (Collective); rank 0 draws it and tells the others.
  uint64_t nextExchange() { return ++lastExchange_; }
  RankCollectives collectives(uint64_t exchange, std::function<void()> check = {},
                              std::function<void(double)> done = {}) {
    return {collective, rank(), ranks(), exchange, std::move(check), std::move(done)};
  }

  /// Work::callAll, with an error that all ranks have alike told once.
  std::vector<nlohmann::json> callAll(const std::string& name, const nlohmann::json& parameters);
  /// What it returns of the replies of all ranks, or throws.
  std::vector<nlohmann::json> resultsOf(std::vector<Work::Reply> replies) const;

  /// What the work returns on each rank that replies, by rank, and the others: those that were missing before, which are
  /// not sent it, and those whose replies have not come within options.rankPatience. Throws what resultsOf() does.
  struct RollCall {
    std::vector<nlohmann::json> results;
    std::vector<Presence::Missing> missing;
  };
  RollCall callThoseThere(const std::string& name, const nlohmann::json& parameters);

  /// Enters so many bytes of a tenant in the ledger. Throws Error if it may not have them on this rank.
  [[nodiscard]] LedgerEntry takeMemory(const std::string& tenant, const std::string& purpose, int64_t bytes);

  /// What a rendering of so many pixels takes of its tenant. All pictures in flight have to fit beside what the tenant has
  /// on rank 0, as if that rank owned them all. Rank 0.
  Tenants::Cost costOf(const std::string& tenant, glm::ivec2 size) const;

  Transport& transport;
  const NodeOptions options;
  const DataFolders folders;
  Ledger ledger;
  Observers observers;
  Objects objects{observers};
  KeySource keys;
  Directory directory;   ///< rank 0's counts
  Tenants tenants;       ///< rank 0
  ReadingTurns reading;  ///< rank 0
  const std::unique_ptr<Backend> backend;
  Collective collective;
  Exchanges exchanges;
  Renderer renderer;
  const std::unique_ptr<Datasets> datasets;
  const std::unique_ptr<Modules> modules;
  Presence presence;  ///< rank 0's server asks
  Work work;          ///< last: its actions use all others

  /// What the listening server on rank 0 answers for; set before clients come.
  std::function<nlohmann::json()> clients = [] { return nlohmann::json::array(); };
  std::function<void()> stop = [] {};

  const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

 private:
  std::atomic<uint64_t> lastExchange_ = 1;
  std::mutex memory_;
};

}  // namespace gxy
