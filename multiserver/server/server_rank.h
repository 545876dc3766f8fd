// SPDX-License-Identifier: Apache-2.0
// One rank of the server, with all its parts that modules use.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/analysis/tracer.h"
#include "core/comm/collective.h"
#include "core/comm/collectives.h"
#include "core/comm/error.h"
#include "core/comm/presence.h"
#include "core/comm/work.h"
#include "core/rays/backend.h"
#include "core/rays/field_maker.h"
#include "core/render/renderer.h"
#include "core/space/directory.h"
#include "core/space/ledger.h"
#include "core/space/objects.h"
#include "multiserver/server/data_folders.h"
#include "multiserver/server/document_reader.h"
#include "multiserver/server/exchanges.h"
#include "multiserver/server/tenants.h"
#include "multiserver/server/tickets.h"

namespace gxy {

class Datasets;
class FilterRuns;
class Modules;
class Sampler;

/// Thrown where the ledger has no room.
class NoRoom : public Error {
 public:
  using Error::Error;
};

struct ServerRankOptions {
  std::vector<std::string> dataFolders;    ///< empty: the current folder
  std::vector<std::string> moduleFolders;  ///< searched in this order; empty: there are no modules
  std::string backend = "auto";
  int64_t memory = int64_t(8) << 30;        ///< bytes on each rank for all tenants together
  int64_t tenantMemory = int64_t(8) << 30;  ///< bytes on each rank for one tenant
  int tenantFrames = 64;                    ///< renderings in flight for one tenant
  /// The longest time for which an unfinished picture may delay an update of another tenant's data.
  std::chrono::milliseconds longestHold{10000};
  std::chrono::milliseconds rankPatience{10000};  ///< a rank that is silent for this long is missing
  int threads = 2;                                ///< threads of each rank that run its tasks
  int64_t raysInFlight = 1 << 20;                 ///< rays in flight on each rank
  /// A publisher that waits for this long for the room of a generation that a graph reads or shows gets it: the data become the
  /// graph's own.
  std::chrono::milliseconds adoptAfter{1000};
  /// What a graph evaluates for a view goes on for so long after the view's last window has gone.
  std::chrono::milliseconds leftViewsFor{60'000};
  std::string insituBind = "127.0.0.1";  ///< the address on which each rank takes data of simulations
  Trace* trace = nullptr;  ///< gets requests, works and rendering, unless null; outlives the server rank
};

/// Made on every rank at the same time, over the rank's Transport, and destroyed on all ranks together. Each
/// of its parts is thread safe. The order of members is that of their dependencies.
struct ServerRank {
  /// Throws Error, possibly on this rank only, for options that cannot be satisfied.
  ServerRank(Transport& transport, ServerRankOptions options, const BackendRegistry& backends);
  ~ServerRank();
  ServerRank(const ServerRank&) = delete;
  ServerRank& operator=(const ServerRank&) = delete;

  int rank() const { return transport.rank(); }
  int ranks() const { return transport.size(); }

  /// Returns a new key for a Collective. Rank 0 calls it and sends the key to the others.
  uint64_t nextExchange() { return ++lastExchange_; }
  RankCollectives collectives(uint64_t exchange, std::function<void()> check = {},
                              std::function<void(double)> done = {}) {
    return {collective, rank(), ranks(), exchange, std::move(check), std::move(done)};
  }

  /// Like Work::callAll(), but an error that is the same on all ranks is stated once.
  std::vector<nlohmann::json> callAll(const std::string& name, const nlohmann::json& parameters,
                                      std::span<const std::byte> attachment = {});
  /// Returns the results of the replies of all ranks, or throws Error as callAll() does.
  std::vector<nlohmann::json> resultsOf(std::vector<Work::Reply> replies) const;

  struct RollCall {
    std::vector<nlohmann::json> results;     ///< of the ranks that have replied, in the order of ranks
    std::vector<Presence::Missing> missing;  ///< the other ranks
  };
  /// Sends a work to all ranks that are not missing and waits for their replies, but at most
  /// options.rankPatience. Throws Error as resultsOf() does.
  RollCall callThoseThere(const std::string& name, const nlohmann::json& parameters);

  /// Enters memory of a tenant in this rank's ledger. Throws NoRoom if the tenant's limit or the rank's
  /// would be exceeded.
  [[nodiscard]] LedgerEntry takeMemory(const std::string& tenant, const std::string& purpose, int64_t bytes);

  /// Returns the memory that a picture of this size takes of its tenant. All pictures in flight must fit
  /// beside the tenant's other memory on rank 0, as if that rank owned them all. Only for rank 0.
  Tenants::Cost costOf(const std::string& tenant, glm::ivec2 size) const;

  Transport& transport;
  const ServerRankOptions options;
  const DataFolders folders;
  Ledger ledger;
  Observers observers;
  Objects objects{observers};
  KeySource keys;
  Directory directory;   ///< used on rank 0
  Tenants tenants;       ///< used on rank 0
  Tickets tickets;       ///< used on rank 0
  ReadingTurns reading;  ///< used on rank 0
  const std::unique_ptr<Backend> backend;
  Collective collective;
  Exchanges exchanges;
  Renderer renderer;
  FieldMaker fieldMaker;
  Tracer tracer;
  const std::unique_ptr<Sampler> sampler;
  /// What no session has asked for, on rank 0: the streams of simulations (multiserver/insitu). The Server asks, and ends them.
  class Streaming {
   public:
    void set(std::function<nlohmann::json()> list, std::function<void()> end) {
      const std::lock_guard lock(mutex_);
      list_ = std::move(list);
      end_ = std::move(end);
    }
    void reset() {
      set([] { return nlohmann::json::array(); }, [] {});
    }
    /// The streams of all tenants, as `insitu.streams` tells them.
    nlohmann::json list() const { return function(list_)(); }
    /// Ends them, and waits. None begins any more.
    void end() const { function(end_)(); }

   private:
    template <class F>
    F function(const F& f) const {
      const std::lock_guard lock(mutex_);
      return f;
    }
    mutable std::mutex mutex_;
    std::function<nlohmann::json()> list_ = [] { return nlohmann::json::array(); };
    std::function<void()> end_ = [] {};
  } streaming;
  /// What modules have to end while all ranks still answer. The Server on rank 0 ends it after all sessions. Thread safe.
  class Endings {
   public:
    void add(std::function<void()> end) {
      const std::lock_guard lock(mutex_);
      ends_.push_back(std::move(end));
    }
    /// Calls each once, and waits for what they wait for.
    void end() {
      std::vector<std::function<void()>> ends;
      {
        const std::lock_guard lock(mutex_);
        ends.swap(ends_);
      }
      for (const auto& end : ends) end();
    }

   private:
    std::mutex mutex_;
    std::vector<std::function<void()>> ends_;
  } endings;
  Filters filters;  ///< the standard ones, and those of modules
  const std::unique_ptr<Datasets> datasets;
  const std::unique_ptr<FilterRuns> filterRuns;
  const std::unique_ptr<Modules> modules;
  Presence presence;  ///< rank 0's Server asks
  Work work;          ///< the last part, because its actions use all others

  /// Functions of the Server on rank 0, which sets them before clients come: a list of clients, and
  /// stopping the server.
  std::function<nlohmann::json()> clients = [] { return nlohmann::json::array(); };
  std::function<void()> stop = [] {};
  const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

 private:
  std::atomic<uint64_t> lastExchange_ = 1;
  std::mutex memory_;
};

}  // namespace gxy
