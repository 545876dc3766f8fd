// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/server_rank.h"

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <future>
#include <map>
#include <set>

#include "core/analysis/sampler.h"
#include "core/comm/error.h"
#include "multiserver/server/data_export.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"
#include "multiserver/server/modules.h"
#include "multiserver/server/server_verbs.h"

namespace gxy {

namespace {

// Checks options before any part is made that other ranks could send messages to.
ServerRankOptions checked(ServerRankOptions options) {
  std::error_code failed;
  for (const std::string& folder : options.moduleFolders)
    if (!std::filesystem::is_directory(folder, failed))
      throw Error(folder + ": it is no folder, expected one of the server's modules");
  return options;
}

Sampler::Options samplerOptions(const ServerRankOptions& options, const BackendRegistry& backends,
                                Ledger& ledger) {
  Sampler::Options s;
  s.other = backends.forFields();
  s.runners = options.threads;
  s.ledger = &ledger;
  s.trace = options.trace;
  s.tenant = "server";
  return s;
}

Renderer::Options rendererOptions(const ServerRankOptions& options, Ledger& ledger) {
  Renderer::Options r;
  r.raysInFlight = options.raysInFlight;
  r.runners = options.threads;
  r.handOuts = options.threads;  // A single batch needs as many, as encoding its pictures may take longest.
  r.ledger = &ledger;
  r.trace = options.trace;
  r.tenant = "server";
  return r;
}

Tracer::Options tracerOptions(const ServerRankOptions& options, Ledger& ledger) {
  Tracer::Options t;
  t.heads = std::max<int64_t>(1, options.raysInFlight / 4);
  t.runners = options.threads;
  t.ledger = &ledger;
  t.tenant = "server";
  t.trace = options.trace;
  return t;
}

}  // namespace

ServerRank::ServerRank(Transport& t, ServerRankOptions o, const BackendRegistry& backends)
    : transport(t),
      options(checked(std::move(o))),
      folders(options.dataFolders),
      keys(t.rank()),
      tenants(options.tenantFrames),
      backend(backends.make(options.backend, &ledger)),
      collective(t),
      exchanges(*this),
      renderer(t, rendererOptions(options, ledger)),
      fieldMaker(*backend, backends, &ledger),
      tracer(t, tracerOptions(options, ledger)),
      sampler(std::make_unique<Sampler>(t, *backend, samplerOptions(options, backends, ledger))),
      datasets(std::make_unique<Datasets>(*this)),
      filterRuns(std::make_unique<FilterRuns>(*this)),
      modules(std::make_unique<Modules>(*this)),
      presence(t),
      work(t, options.trace) {
  addStandardFilters(filters);
  exchanges.addWorks();
  datasets->addWorks();
  filterRuns->addWorks();
  modules->addWorks();
  addExportWork(*this);
  addServerWorks(*this);
}

ServerRank::~ServerRank() = default;

std::vector<nlohmann::json> ServerRank::callAll(const std::string& name, const nlohmann::json& parameters,
                                                std::span<const std::byte> attachment) {
  const auto promise = std::make_shared<std::promise<std::vector<Work::Reply>>>();
  work.broadcast(
      name, parameters,
      [promise](std::vector<Work::Reply> replies) { promise->set_value(std::move(replies)); }, attachment);
  return resultsOf(promise->get_future().get());
}

ServerRank::RollCall ServerRank::callThoseThere(const std::string& name, const nlohmann::json& parameters) {
  struct Replies {
    std::mutex mutex;
    std::condition_variable changed;
    std::map<int, Work::Reply> there;
  };
  RollCall call{{}, presence.missing(options.rankPatience)};
  const auto replies = std::make_shared<Replies>();  // Replies may come after this has returned.
  const auto isMissing = [&](int rank) {
    return std::any_of(call.missing.begin(), call.missing.end(),
                       [&](const auto& m) { return m.rank == rank; });
  };
  for (int r = 0; r < ranks(); r++)
    if (!isMissing(r))
      work.send(r, name, parameters, [replies](std::vector<Work::Reply> reply) {
        const std::lock_guard lock(replies->mutex);
        replies->there.emplace(reply.front().rank, std::move(reply.front()));
        replies->changed.notify_all();
      });
  const size_t sent = size_t(ranks()) - call.missing.size();
  std::unique_lock lock(replies->mutex);
  replies->changed.wait_for(lock, options.rankPatience, [&] { return replies->there.size() == sent; });
  for (int r = 0; r < ranks(); r++)
    if (!isMissing(r) && replies->there.count(r) == 0)
      call.missing.push_back(
          {r, false, std::chrono::duration_cast<std::chrono::seconds>(options.rankPatience)});
  std::vector<Work::Reply> came;
  for (auto& [rank, reply] : replies->there) came.push_back(std::move(reply));
  call.results = resultsOf(std::move(came));
  return call;
}

std::vector<nlohmann::json> ServerRank::resultsOf(std::vector<Work::Reply> replies) const {
  std::vector<nlohmann::json> results;
  std::string all;
  int failed = 0;
  std::set<std::string> reasons;
  for (Work::Reply& reply : replies) {
    if (!reply.ok()) {
      const std::string prefix = "rank " + std::to_string(reply.rank) + ": ";
      const std::string reason =
          reply.error.starts_with(prefix) ? reply.error.substr(prefix.size()) : reply.error;
      failed++;
      reasons.insert(reason);
      all += (all.empty() ? "" : "; ") + prefix + reason;
    }
    results.push_back(std::move(reply.result));
  }
  if (reasons.size() == 1 && failed == ranks()) throw Error(*reasons.begin());
  if (!reasons.empty()) throw Error(all);
  return results;
}

LedgerEntry ServerRank::takeMemory(const std::string& tenant, const std::string& purpose, int64_t bytes) {
  const std::lock_guard lock(memory_);  // Check and entry must be one step.
  const auto check = [&](int64_t used, int64_t limit, const std::string& whose) {
    if (bytes > limit - used)
      throw NoRoom("memory: " + std::to_string(bytes) + " bytes are needed, but of " + whose + "'s " +
                   std::to_string(limit) + " bytes " + std::to_string(used) +
                   " are in use, expected room for them");
  };
  check(ledger.total(tenant), options.tenantMemory, "tenant " + tenant);
  check(ledger.total(), options.memory, "this rank");
  return ledger.enter(tenant, purpose, bytes);
}

Tenants::Cost ServerRank::costOf(const std::string& tenant, glm::ivec2 size) const {
  // A pixel takes 32 bytes in the framebuffer, 16 in the picture, and the rest in tiles and messages.
  constexpr int64_t kBytes = 64;
  return {int64_t(size.x) * size.y * kBytes, [this, tenant] {
            return std::min(options.tenantMemory - ledger.total(tenant), options.memory - ledger.total());
          }};
}

}  // namespace gxy
