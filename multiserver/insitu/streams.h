// SPDX-License-Identifier: Apache-2.0
// The streams of simulations that a rank of the server takes part in.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "multiserver/insitu/data_port.h"
#include "multiserver/insitu/stream_lead.h"
#include "multiserver/insitu/stream_part.h"

namespace gxy {

/// There is one on each rank. Thread safe.
class Streams {
 public:
  static constexpr size_t kOfTenant = 16;  ///< streams of one tenant at a time

  /// `works` registers works by name.
  using AddWork = std::function<void(const std::string& name, Work::Action action, Work::Runs runs)>;
  Streams(ServerRank& serverRank, const AddWork& addWork);
  ~Streams();

  /// A rank of a simulation that wants to publish.
  struct Join {
    std::string name;
    int rank = 0, ranks = 1;
    StreamWishes wishes;
    std::vector<Trigger> triggers{};  ///< that the rank brings with it
  };
  /// Rank 0: joins a stream of the tenant, or begins it. Returns what `insitu.join` replies. Throws Error where the stream has other
  /// members or wishes, or the tenant has too many streams.
  nlohmann::json join(const std::string& tenant, const Join& join);
  /// Rank 0: the streams of a tenant, or of all for an empty name.
  nlohmann::json list(const std::string& tenant) const;
  /// Rank 0: ends a stream of the tenant. Throws Error if there is none of this name.
  void close(const std::string& tenant, const std::string& name);
  /// Rank 0: as StreamLead::steer(), of a stream of the tenant.
  void steer(const std::string& tenant, const std::string& name, const insitu::Steering& values);
  /// Rank 0: calls `action` with the triggers of a stream of the tenant. Throws Error if there is none of this name.
  void withTriggers(const std::string& tenant, const std::string& name,
                    const std::function<void(Triggers&)>& action);

  /// Rank 0: events about the tenant's streams go to the outbox from now on, as long as what this returns lives.
  [[nodiscard]] std::shared_ptr<void> listen(const std::string& tenant, std::shared_ptr<Outbox> outbox);

 private:
  nlohmann::json openHere(const nlohmann::json& parameters);
  nlohmann::json stepHere(const nlohmann::json& parameters);
  nlohmann::json endHere(const nlohmann::json& parameters);
  std::shared_ptr<DataTaker> admit(const insitu::Hello& hello, std::shared_ptr<DataLink> link);
  std::shared_ptr<StreamPart> part(uint64_t stream) const;
  std::shared_ptr<StreamLead> lead(uint64_t stream) const;
  std::shared_ptr<StreamLead> leadOf(const std::string& tenant, const std::string& name) const;
  void begin(const std::string& tenant, const Join& join);
  void ended(uint64_t stream);
  void tell(const std::string& tenant, const nlohmann::json& event);
  void endAll();

  ServerRank& serverRank_;
  std::mutex joining_;        ///< rank 0: held while a stream begins; guards stopped_
  bool stopped_ = false;      ///< no stream begins any more
  mutable std::mutex mutex_;  ///< guards the others
  std::map<uint64_t, std::shared_ptr<StreamPart>> parts_;
  std::unique_ptr<DataPort> port_;                         ///< while there are streams
  std::map<uint64_t, std::shared_ptr<StreamLead>> leads_;  ///< rank 0
  std::map<uint64_t, nlohmann::json> ports_;               ///< rank 0: where each rank takes data, by stream
  std::vector<std::shared_ptr<StreamLead>> over_;          ///< rank 0: have ended, and are to be destroyed
  struct Listener {
    std::string tenant;
    std::shared_ptr<Outbox> outbox;
  };
  std::vector<std::weak_ptr<Listener>> listeners_;  ///< rank 0
};

}  // namespace gxy
