// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/stream_part.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/comm/crc32c.h"
#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/dataset.h"
#include "core/data/partitioning_bytes.h"
#include "multiserver/insitu/cells_room.h"
#include "multiserver/insitu/grid_room.h"
#include "multiserver/insitu/points_room.h"
#include "multiserver/insitu/volume_room.h"
#include "multiserver/server/datasets.h"

namespace gxy {

using insitu::Piece;
using insitu::Receiver;

Bytes written(const StreamPlan& plan) {
  Writer w;
  w.write(insitu::written(plan.meshes));
  for (const auto& blocks : plan.blocks) w.write(blocks);
  return w.write(plan.homes).write(written(*plan.partitioning)).take();
}

StreamPlan readPlan(std::span<const std::byte> message) {
  Reader r(message, "plan of a stream");
  StreamPlan plan;
  plan.meshes = insitu::readMeshes(r.readVector<std::byte>());
  for (size_t m = 0; m < plan.meshes.size(); m++) plan.blocks.push_back(r.readVector<insitu::Block>());
  plan.homes = r.readVector<int>();
  plan.partitioning = std::make_shared<const Partitioning>(readPartitioning(r.readVector<std::byte>()));
  r.expectEnd();
  return plan;
}

StreamPart::StreamPart(ServerRank& serverRank, StreamIdentity identity, Tell tell)
    : serverRank_(serverRank), identity_(std::move(identity)), tell_(std::move(tell)) {}

bool StreamPart::shows(const insitu::Hello& hello) const {
  uint8_t different = 0;
  for (size_t i = 0; i < hello.ticket.size(); i++) different |= hello.ticket[i] ^ identity_.ticket[i];
  return different == 0 && hello.stream == identity_.id && hello.rank < uint32_t(identity_.ranks);
}

void StreamPart::plan(StreamPlan plan) {
  std::vector<insitu::BlockSearch> searches;
  for (auto& blocks : plan.blocks) searches.emplace_back(std::exchange(blocks, {}));
  std::vector<std::vector<Piece>> pieces(size_t(identity_.ranks));
  for (const Piece& piece :
       insitu::piecesFor(serverRank_.rank(), {plan.meshes, searches, plan.homes, *plan.partitioning}))
    pieces[size_t(piece.rank)].push_back(piece);
  std::vector<std::vector<Place>> places(pieces.size());
  for (size_t r = 0; r < pieces.size(); r++)
    for (const Piece& piece : pieces[r])
      for (size_t a = 0; a < arraysOf(plan.meshes[size_t(piece.mesh)]).size(); a++)
        places[r].push_back({piece, a});
  std::vector<std::optional<GhostPlan>> ghosts(plan.meshes.size());
  for (size_t m = 0; m < ghosts.size(); m++)
    if (plan.meshes[m].kind == insitu::Mesh::Kind::Grid)
      ghosts[m].emplace(plan.meshes[m].grid, *plan.partitioning, kGhostLayers, serverRank_.rank(),
                        serverRank_.ranks());
  const std::lock_guard lock(mutex_);
  plan_ = std::move(plan);
  pieces_ = std::move(pieces);
  places_ = std::move(places);
  ghosts_ = std::move(ghosts);
  for (size_t m = 0; m < plan_->meshes.size(); m++)
    if (plan_->meshes[m].shape == insitu::Mesh::Shape::Volume)
      kept_[m].keep(nullptr);  // It is of other partitions, perhaps.
  expect(expected_);
}

// Steps come by the plan, and with these encodings. With the lock held.
void StreamPart::expect(const insitu::Encodings& encodings) {
  const std::vector<insitu::Mesh> sent = encoded(plan_->meshes, encodings);
  std::vector<Receiver::Source> sources;
  for (const auto& pieces : pieces_) sources.push_back(itemsOf(pieces, sent));
  if (receiver_)
    receiver_->expect(std::move(sources));
  else
    receiver_.emplace(std::move(sources));
  expected_ = encodings;
}

bool StreamPart::connect(int rank, std::shared_ptr<DataLink> link, insitu::Checksum checksum) {
  const std::lock_guard lock(mutex_);
  return !over_ && links_.emplace(rank, Link{std::move(link), checksum}).second;
}

void StreamPart::disconnect(int rank, const std::string& reason, bool regularly) {
  {
    const std::lock_guard lock(mutex_);
    links_.erase(rank);
  }
  if (!regularly) tell_.lost("rank " + std::to_string(rank) + " of the simulation: " + reason);
}

void StreamPart::send(int rank, protocol::WireMessage message) {
  const std::lock_guard lock(mutex_);
  if (const auto link = links_.find(rank); link != links_.end()) link->second.link->send(std::move(message));
}

void StreamPart::end(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  over_ = true;
  for (auto& [mesh, kept] : kept_) kept.keep(nullptr);
  for (const auto& [rank, link] : links_) link.link->bye(reason);
}

size_t StreamPart::connections() const {
  const std::lock_guard lock(mutex_);
  return links_.size();
}

size_t StreamPart::checkedConnections() const {
  const std::lock_guard lock(mutex_);
  return size_t(std::count_if(links_.begin(), links_.end(),
                              [](const auto& one) { return one.second.checksum != insitu::Checksum::None; }));
}

bool StreamPart::isConnected(int rank) const {
  const std::lock_guard lock(mutex_);
  return links_.count(rank) > 0;
}

std::string StreamPart::damaged(const Place& place, const insitu::PieceHeader& header, size_t bytes,
                                uint32_t found) const {
  const insitu::Mesh& mesh = plan_->meshes[size_t(place.piece.mesh)];
  char checksums[64];
  std::snprintf(checksums, sizeof checksums, "%08x, expected %08x", found, header.checksum);
  return "samples were damaged on their way: publish " + std::to_string(header.count) + ", item " +
         std::to_string(header.item) + " (\"" + arraysOf(mesh)[place.array].name + "\" of mesh \"" +
         mesh.name + "\"), " + std::to_string(bytes) + " bytes from byte " + std::to_string(header.offset) +
         " have the CRC-32C " + checksums;
}

void StreamPart::takePiece(int rank, insitu::Checksum checksum, std::span<const std::byte> samples) {
  const insitu::PieceHeader header = insitu::takePieceHeader(samples);
  const uint32_t found = checksum == insitu::Checksum::Crc32c ? crc32c(samples) : header.checksum;
  uint64_t complete = 0, bytes = 0;
  std::string problem;
  {
    const std::lock_guard lock(mutex_);
    if (!receiver_) throw Error("samples before there is a plan, expected them after it");
    if (!receiver_->accept(rank, header, samples.size())) return;
    const Place& place = places_[size_t(rank)].at(header.item);
    if (found != header.checksum) throw Error(damaged(place, header, samples.size(), found));
    try {
      rooms_.at(size_t(place.piece.mesh))->store(place.piece, place.array, header, samples);
    } catch (const std::exception& e) {
      problem = e.what();
      receiver_->refuse(header.count);
    }
    bytes = bytes_ += samples.size();
    if (receiver_->complete()) complete = receiver_->count();
  }
  if (!problem.empty()) return tell_.refused(header.count, problem);
  if (complete > 0) tell_.complete(complete, bytes);
}

void StreamPart::makeRoom(const insitu::Encodings& encodings) {
  const TakeStepMemory take = [this](const char* purpose, int64_t bytes) {
    return serverRank_.takeMemory(identity_.tenant, purpose, bytes);
  };
  std::vector<std::unique_ptr<MeshRoom>> rooms;
  for (size_t m = 0; m < plan_->meshes.size(); m++) {
    const insitu::Mesh& mesh = plan_->meshes[m];
    if (mesh.kind == insitu::Mesh::Kind::Grid)
      rooms.push_back(std::make_unique<GridRoom>(mesh, m, encodings, *plan_->partitioning, *ghosts_[m],
                                                 serverRank_.rank(), take));
    else if (mesh.kind == insitu::Mesh::Kind::Points)
      rooms.push_back(std::make_unique<PointsRoom>(mesh, take));
    else if (mesh.shape == insitu::Mesh::Shape::Volume)
      rooms.push_back(std::make_unique<VolumeRoom>(mesh, *plan_->partitioning, take, kept_.at(m)));
    else
      rooms.push_back(std::make_unique<CellsRoom>(mesh, take));
  }
  const std::lock_guard lock(mutex_);
  if (encodings != expected_) expect(encodings);
  unfit_ = false;
  rooms_ = std::move(rooms);
  receiver_->open();
}

CollectedStep StreamPart::step(Publication& publication, uint64_t exchange, Exchanges::Part& part,
                               const insitu::Encodings& encodings,
                               const std::function<CollectedStep()>& collect,
                               const std::function<uint64_t()>& last) {
  RankCollectives& ranks = part.ranks;
  struct Told {
    CollectedStep step;
    uint64_t last = 0;
  } told;
  // Whatever happens, nothing more is stored here.
  const std::shared_ptr<void> closing(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    receiver_->close(std::max(told.last, told.step.count));
    rooms_.clear();
  });
  publication.reserve();
  agree(ranks, [&] { makeRoom(encodings); });
  std::string failure;
  if (serverRank_.rank() == 0) {
    try {
      told.step = collect();
    } catch (const std::exception& e) {
      failure = e.what();
    }
    told.last = last();
  }
  const Bytes bytes = serverRank_.collective.broadcast(exchange, 0, Writer().write(told).take());
  told = Reader(bytes, "collected step").read<Told>();
  agree(ranks, [&] {
    if (!failure.empty()) throw Error(failure);
    if (told.step.count > 0) takeRoom(told.step);
  });
  complete(publication, told.step, encodings, ranks);
  serverRank_.datasets->publish(publication, exchange);
  return told.step;
}

void StreamPart::takeRoom(const CollectedStep& step) {
  const std::lock_guard lock(mutex_);
  if (!receiver_->take(step.count))
    throw Error("step " + std::to_string(step.step) + " is not complete here, expected all of its samples");
}

// Throws the same Error on all ranks if floats with these encodings are not exact enough for the values of the step.
void StreamPart::learnEncodings(const std::vector<std::shared_ptr<Dataset>>& datasets,
                                const insitu::Encodings& encodings) {
  constexpr int kPlain = 10;  // steps, so that not every other one is lost where ranges change all the time
  const std::vector<insitu::Publishes> all = insitu::datasetsOf(plan_->meshes);
  insitu::Encodings learned;
  std::string unfit;
  for (size_t i = 0; i < datasets.size(); i++) {
    const Volume* volume = datasets[i]->volume.get();
    if (!volume || !all[i].field) continue;
    const insitu::FieldEncoding now{uint32_t(all[i].mesh), uint32_t(*all[i].field), volume->shift,
                                    volume->scale};
    if (!mayBeEncoded(plan_->meshes, now)) continue;
    Range values;
    for (int c = 0; c < volume->components; c++) values.extend(volume->ranges[size_t(c)]);
    // One value says nothing of those to come, and floats that are all the same may be doubles that are not.
    const bool isOne = values.min == values.max;
    if (!isOne) learned.push_back(now);
    if (const insitu::FieldEncoding* e = encodingIn(encodings, now.mesh, now.field))
      if (isOne || !suffices({ScalarType::Float32, e->shift, e->scale}, ScalarType::Float64,
                             volume->components, values))
        unfit = all[i].name;
  }
  const std::lock_guard lock(mutex_);
  if (!unfit.empty()) {
    learned_.clear();
    unfit_ = true;
    plain_ = kPlain;
    throw Error("the values of \"" + unfit +
                "\" are not where they were, so the next steps are sent as doubles, not as floats");
  }
  plain_ = std::max(0, plain_ - 1);
  learned_ = plain_ > 0 ? insitu::Encodings() : learned;
}

uint64_t StreamPart::stepsWithTheSameCells() const {
  const std::lock_guard lock(mutex_);
  uint64_t steps = 0;
  for (const auto& [mesh, kept] : kept_) steps += kept.uses();
  return steps;
}

bool StreamPart::wasUnfit() const {
  const std::lock_guard lock(mutex_);
  return unfit_;
}

insitu::Encodings StreamPart::encodings() const {
  const std::lock_guard lock(mutex_);
  return learned_;
}

void StreamPart::complete(Publication& publication, const CollectedStep& step,
                          const insitu::Encodings& encodings, RankCollectives& ranks) {
  std::vector<std::shared_ptr<Dataset>> datasets;
  for (const auto& room : rooms_) {
    const auto some = room->complete(ranks);
    datasets.insert(datasets.end(), some.begin(), some.end());
  }
  learnEncodings(datasets, encodings);
  agree(ranks, [&] {
    for (size_t i = 0; i < datasets.size(); i++) {
      datasets[i]->stream = identity_.name;
      datasets[i]->partitioning = plan_->partitioning;
      datasets[i]->origins = {{identity_.id, step.step}};
      datasets[i]->time = step.time;
      publication.stage(i, Payload(std::shared_ptr<const Dataset>(std::move(datasets[i]))));
    }
  });
}

}  // namespace gxy
