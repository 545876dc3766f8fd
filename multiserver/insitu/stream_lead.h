// SPDX-License-Identifier: Apache-2.0
// What rank 0 of the server does for one stream: it plans, decides when a step is taken, and has it published.
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/space/directory.h"
#include "insitu/plan/conductor.h"
#include "multiserver/insitu/stream_part.h"
#include "multiserver/insitu/triggers.h"

namespace gxy {

/// What the first rank that joins asks for; the others must ask for the same.
struct StreamWishes {
  Scope scope = Scope::Private;
  nlohmann::json partition = "even";  ///< or "simulation", or {"like": DATASET}
  struct Steerable {
    std::string name;
    double least = 0, largest = 0;
    bool operator==(const Steerable&) const = default;
  };
  std::vector<Steerable> steerable{};  ///< parameters of the simulation
  bool operator==(const StreamWishes&) const = default;
};

/// The lead of a stream. It has a thread. Thread safe.
class StreamLead {
 public:
  /// `part` is rank 0's. `onEnd` is called once on the lead's thread, when the stream has ended on all ranks.
  /// `tell` tells clients of the tenant who listen to streams.
  StreamLead(ServerRank& serverRank, std::shared_ptr<StreamPart> part, StreamWishes wishes,
             Triggers::Tell tell, std::function<void()> onEnd);
  /// Ends the stream and waits. Not on the lead's thread.
  ~StreamLead();
  StreamLead(const StreamLead&) = delete;
  StreamLead& operator=(const StreamLead&) = delete;

  const StreamIdentity& identity() const { return part_->identity(); }
  const StreamWishes& wishes() const { return wishes_; }

  /// A message of a rank of the simulation. Throws Error for one that is wrong.
  void take(int rank, const protocol::WireMessage& message);
  /// A rank of the simulation has closed the stream.
  void closed(int rank);
  /// A rank of the server has all samples of a step, and has stored so many bytes so far.
  void complete(int owner, uint64_t count, uint64_t bytes);
  /// A rank of the server cannot keep a step.
  void refused(uint64_t count, const std::string& reason);
  /// Ends the stream soon. Its data stay.
  void end(const std::string& reason);
  bool ending() const;
  /// The same, without waiting for what triggers have begun.
  void stop(const std::string& reason);
  /// Waits until the stream has ended on all ranks. Not on the lead's thread.
  void join();
  bool isConnected(int rank) const { return part_->isConnected(rank); }

  Triggers& triggers() { return triggers_; }
  /// Gives parameters of the simulation other values, with its next step. Throws Error for one that is not declared, or a value out of
  /// its range; then nothing has changed.
  void steer(const insitu::Steering& values);

  /// The part of rank 0 in the work that publishes a step.
  CollectedStep collect(const std::function<void()>& check);
  uint64_t lastAppointed() const;

  /// What `insitu.streams` tells.
  nlohmann::json statistics() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Ended {};  ///< thrown on the lead's thread
  /// When a step went from stage to stage.
  struct Course {
    Clock::time_point begun, hasRoom, taken, collected;
  };
  struct Seconds {
    double reserve = 0, collect = 0, complete = 0;
  };

  void run();
  /// What a rank has said last. Ranks that say the same of the meshes share it.
  struct Said {
    uint64_t from = 0;  ///< the publish from which on it is true; 0: the rank has said nothing
    std::shared_ptr<const std::vector<insitu::Mesh>> meshes;
    std::vector<insitu::Part> parts;
  };
  using Bounds = std::vector<std::vector<Box>>;  ///< of particles and cells, by rank and mesh
  void describe(int rank, insitu::Description description);
  std::unique_lock<std::mutex> awaitDescriptions();
  std::vector<insitu::Mesh> mergedMeshes() const;
  void checkRoom(const Partitioning& partitioning) const;
  void plan();
  std::shared_ptr<const Partitioning> cut(const StreamPlan& plan, const Bounds& bounds) const;
  void checkInside(const Partitioning& partitioning) const;
  Box domain(const Bounds& bounds) const;
  std::vector<int> homes(const Partitioning& partitioning, const Bounds& bounds) const;
  void publishSteps();
  void publishNext();
  void awaitNext(Clock::time_point begin);
  bool wanted() const;
  bool isNear(uint64_t publish, Clock::time_point now);
  uint64_t publishOf(int64_t step) const;
  StepValues valuesOf(const std::string& field) const;
  void pullTriggers();
  struct Look {
    uint64_t newest = 0;
    Clock::time_point at;
  } look_;  ///< how many publishes there had been; used by the lead's thread only
  bool publishOne();
  void isPublished();
  void tell(const std::vector<insitu::Control>& messages);
  void tellEncodings();
  bool steers() const { return told_ != steered_; }
  void finish();

  ServerRank& serverRank_;
  const std::shared_ptr<StreamPart> part_;
  const StreamWishes wishes_;
  const Triggers::Tell tell_;
  const std::function<void()> onEnd_;
  Triggers triggers_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<std::string> end_;  ///< why the stream ends
  std::vector<Said> said_;          ///< by rank
  std::shared_ptr<const std::vector<insitu::Mesh>> newestSaid_;
  size_t described_ = 0;              ///< ranks that have said something
  size_t blocks_ = 0;                 ///< of all ranks
  std::vector<insitu::Mesh> meshes_;  ///< of the plan; none before there is one. The lead's thread changes it
  std::shared_ptr<const Partitioning> partitioning_;       ///< the same; used by the lead's thread only
  std::vector<int> homes_;                                 ///< the same
  std::vector<std::vector<insitu::Block>> plannedBlocks_;  ///< the same; by mesh
  struct Refused {
    uint64_t count = 0;
    std::string reason;
  } refused_;  ///< the last step that a rank could not keep
  insitu::Conductor conductor_;
  bool isHeldUp_ = false;            ///< the step under way was given up, since there is to be another plan
  insitu::Encodings encodings_;      ///< that the step under way is sent with
  insitu::Encodings toldEncodings_;  ///< to the simulation
  insitu::Steering steering_;        ///< values that were ever steered
  uint64_t steered_ = 0, told_ = 0;  ///< how often; and when the simulation was told
  std::string problem_;              ///< why the last step could not be published; empty if it was
  CollectedStep newest_, before_;    ///< that were published last
  Course course_;                    ///< of the step under way
  Seconds seconds_;                  ///< of all published steps together
  std::map<int, uint64_t> bytes_;    ///< of samples that each rank of the server has stored
  int late_ = -1;                    ///< the rank that took the newest step last
  uint64_t from_ = 0;                ///< the publish that is needed next; 0: any
  std::mutex joining_;
  std::thread thread_;
};

}  // namespace gxy
