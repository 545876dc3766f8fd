// SPDX-License-Identifier: Apache-2.0
// What one rank of the server does for one stream: it takes the samples of its partitions.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/data/ghosts.h"
#include "core/space/publication.h"
#include "insitu/plan/encodings.h"
#include "insitu/plan/receiver.h"
#include "multiserver/insitu/data_port.h"
#include "multiserver/insitu/mesh_room.h"
#include "multiserver/insitu/volume_room.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

/// Who a stream belongs to, and how its connections show that they are of it. The same on all ranks.
struct StreamIdentity {
  uint64_t id = 0;
  std::string name, tenant;
  insitu::Ticket ticket{};
  int ranks = 1;  ///< of the simulation
};

/// What all ranks know of the data of a stream.
struct StreamPlan {
  std::vector<insitu::Mesh> meshes;
  std::vector<std::vector<insitu::Block>> blocks;  ///< by mesh; of grids
  std::vector<int> homes;  ///< where the particles and cells of each rank of the simulation go
  std::shared_ptr<const Partitioning> partitioning;
};
Bytes written(const StreamPlan& plan);
StreamPlan readPlan(std::span<const std::byte> message);

/// A step that is published: its number and time, and the count of the publish that it was (insitu/plan/conductor.h).
struct CollectedStep {
  uint64_t count = 0;
  int64_t step = 0;
  double time = 0;
};

/// A rank's part of a stream. Thread safe.
class StreamPart {
 public:
  /// Rank 0 is told by these. They are short.
  struct Tell {
    /// All samples of a step are on this rank, which has stored so many bytes of samples so far.
    std::function<void(uint64_t count, uint64_t bytes)> complete;
    /// A step cannot be kept on this rank.
    std::function<void(uint64_t count, const std::string& reason)> refused;
    std::function<void(const std::string& reason)> lost;  ///< a connection has ended, but not regularly
  };
  StreamPart(ServerRank& serverRank, StreamIdentity identity, Tell tell);

  const StreamIdentity& identity() const { return identity_; }
  bool shows(const insitu::Hello& hello)
      const;  ///< whether it is of this stream; takes the same time for any ticket

  /// Says what comes. Only while no step is collected.
  void plan(StreamPlan plan);

  /// A connection of rank `rank` of the simulation, whose pieces have checksums of this kind. False: there is one already, or the
  /// stream has ended.
  bool connect(int rank, std::shared_ptr<DataLink> link, insitu::Checksum checksum);
  void disconnect(int rank, const std::string& reason, bool regularly);
  void send(int rank, protocol::WireMessage message);
  /// Says bye on all connections. Forgets what was kept for further steps.
  void end(const std::string& reason);
  size_t connections() const;
  size_t checkedConnections() const;  ///< those whose pieces have checksums
  bool isConnected(int rank) const;
  /// Stores what a rank has sent. Throws Error, and stores nothing, for a piece that should not come or whose samples are damaged.
  void takePiece(int rank, insitu::Checksum checksum, std::span<const std::byte> message);

  /// Collective, in a work that joined `publication`. Reserves room, collects a step and publishes it. `encodings` are those that
  /// the step is sent with. `collect` is called on rank 0 once all ranks have room. It waits until all samples are there, or throws;
  /// it returns what was collected, and `last` the count that was appointed last. If any rank fails, all throw Error, and the
  /// data before are current.
  CollectedStep step(Publication& publication, uint64_t exchange, Exchanges::Part& part,
                     const insitu::Encodings& encodings, const std::function<CollectedStep()>& collect,
                     const std::function<uint64_t()>& last);
  /// Returns how the next step may be sent: doubles as floats with the shift and scale that the last step has got.
  insitu::Encodings encodings() const;
  /// Steps in which a mesh of cells with a volume had the points and cells of the step before, so that these were not made anew; of all
  /// meshes together.
  uint64_t stepsWithTheSameCells() const;
  /// Whether the last step was left out since its encodings did not suit its values.
  bool wasUnfit() const;

 private:
  void expect(const insitu::Encodings& encodings);
  void makeRoom(const insitu::Encodings& encodings);
  void takeRoom(const CollectedStep& step);
  void complete(Publication& publication, const CollectedStep& step, const insitu::Encodings& encodings,
                RankCollectives& ranks);
  void learnEncodings(const std::vector<std::shared_ptr<Dataset>>& datasets,
                      const insitu::Encodings& encodings);

  ServerRank& serverRank_;
  const StreamIdentity identity_;
  const Tell tell_;
  mutable std::mutex mutex_;
  struct Link {
    std::shared_ptr<DataLink> link;
    insitu::Checksum checksum = insitu::Checksum::None;
  };
  std::map<int, Link> links_;  ///< by rank of the simulation
  bool over_ = false;          ///< end() has been said
  std::optional<StreamPlan> plan_;
  std::vector<std::optional<GhostPlan>> ghosts_;  ///< by mesh; of grids
  std::optional<insitu::Receiver> receiver_;
  struct Place {
    insitu::Piece piece;
    size_t array = 0;
  };
  std::string damaged(const Place& place, const insitu::PieceHeader& header, size_t bytes,
                      uint32_t found) const;
  uint64_t bytes_ = 0;                              ///< of samples that were stored
  std::vector<std::vector<insitu::Piece>> pieces_;  ///< by rank of the simulation
  std::vector<std::vector<Place>> places_;          ///< of items, by rank of the simulation
  insitu::Encodings expected_;                      ///< by the receiver
  insitu::Encodings learned_;                       ///< from the last step
  bool unfit_ = false;
  int plain_ = 0;                                 ///< steps that are sent as they are before others
  std::map<size_t, KeptVolume> kept_;             ///< by mesh, of cells with a volume
  std::vector<std::unique_ptr<MeshRoom>> rooms_;  ///< by mesh, while a step is collected
};

}  // namespace gxy
