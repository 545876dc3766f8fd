// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/stream_part.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/complete_volume.h"
#include "core/data/dataset.h"
#include "core/data/partitioning_bytes.h"
#include "multiserver/server/datasets.h"

namespace gxy {

using insitu::Piece;
using insitu::Receiver;

Bytes written(const StreamPlan& plan) {
  return Writer()
      .write(written(insitu::Description{plan.mesh, {}}))
      .write(plan.blocks)
      .write(written(*plan.partitioning))
      .take();
}

StreamPlan readPlan(std::span<const std::byte> message) {
  Reader r(message, "plan of a stream");
  StreamPlan plan;
  plan.mesh = insitu::readDescription(r.readVector<std::byte>()).mesh;
  plan.blocks = r.readVector<insitu::Block>();
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
  const Grid& grid = plan.mesh.grid;
  std::vector<std::vector<Piece>> pieces(size_t(identity_.ranks));
  std::vector<Receiver::Source> sources(size_t(identity_.ranks));
  const insitu::BlockSearch search(plan.blocks);
  for (const Piece& piece : piecesFor(serverRank_.rank(), grid, *plan.partitioning, search)) {
    Receiver::Source& source = sources[size_t(piece.rank)];
    for (const insitu::Field& field : plan.mesh.fields) {
      source.items.push_back(uint64_t(piece.points.count()) * field.bytesPerPoint());
      source.bytesPerPoint.push_back(field.bytesPerPoint());
    }
    pieces[size_t(piece.rank)].push_back(piece);
  }
  GhostPlan ghosts(grid, *plan.partitioning, kGhostLayers, serverRank_.rank(), serverRank_.ranks());
  plan.blocks = {};  // not needed any more, and there may be many
  const std::lock_guard lock(mutex_);
  plan_ = std::move(plan);
  pieces_ = std::move(pieces);
  receiver_.emplace(std::move(sources));
  ghosts_.emplace(std::move(ghosts));
}

bool StreamPart::connect(int rank, std::shared_ptr<DataLink> link) {
  const std::lock_guard lock(mutex_);
  return !over_ && links_.emplace(rank, std::move(link)).second;
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
  if (const auto link = links_.find(rank); link != links_.end()) link->second->send(std::move(message));
}

void StreamPart::bye(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  over_ = true;
  for (const auto& [rank, link] : links_) link->bye(reason);
}

size_t StreamPart::connections() const {
  const std::lock_guard lock(mutex_);
  return links_.size();
}

bool StreamPart::isConnected(int rank) const {
  const std::lock_guard lock(mutex_);
  return links_.count(rank) > 0;
}

void StreamPart::takePiece(int rank, std::span<const std::byte> samples) {
  const insitu::PieceHeader header = insitu::takePieceHeader(samples);
  uint64_t complete = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!receiver_) throw Error("samples before there is a plan, expected them after it");
    if (!receiver_->accept(rank, header, samples.size())) return;
    const size_t fields = plan_->mesh.fields.size();
    room_->store(header.item % fields, pieces_[size_t(rank)].at(header.item / fields), header.offset,
                 samples);
    if (receiver_->complete()) complete = receiver_->count();
  }
  if (complete > 0) tell_.complete(complete);
}

void StreamPart::makeRoom(std::vector<LedgerEntry>& memory) {
  for (const insitu::Field& field : plan_->mesh.fields)
    memory.push_back(serverRank_.takeMemory(
        identity_.tenant, "volume",
        bytesToCome(field, plan_->mesh.grid, *plan_->partitioning, serverRank_.rank())));
  auto room = std::make_unique<StepRoom>(plan_->mesh, *plan_->partitioning, serverRank_.rank());
  const std::lock_guard lock(mutex_);
  room_ = std::move(room);
  receiver_->open();
}

CollectedStep StreamPart::step(Publication& publication, uint64_t exchange, Exchanges::Part& part,
                               const std::function<CollectedStep()>& collect,
                               const std::function<uint64_t()>& last) {
  RankCollectives& ranks = part.ranks;
  std::vector<LedgerEntry> memory;
  struct Told {
    CollectedStep step;
    uint64_t last = 0;
  } told;
  // Whatever happens, nothing more is stored here.
  const std::shared_ptr<void> closing(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    receiver_->close(std::max(told.last, told.step.count));
    room_.reset();
  });
  publication.reserve();
  agree(ranks, [&] { makeRoom(memory); });
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
  complete(publication, told.step, std::move(memory), ranks);
  serverRank_.datasets->publish(publication, exchange);
  return told.step;
}

void StreamPart::takeRoom(const CollectedStep& step) {
  const std::lock_guard lock(mutex_);
  if (!receiver_->take(step.count))
    throw Error("step " + std::to_string(step.step) + " is not complete here, expected all of its samples");
}

void StreamPart::complete(Publication& publication, const CollectedStep& step,
                          std::vector<LedgerEntry> memory, RankCollectives& ranks) {
  const std::vector<std::shared_ptr<Volume>>& volumes = room_->volumes();
  std::vector<Volume*> all;
  for (const auto& volume : volumes) all.push_back(volume.get());
  exchangeGhosts(all, *ghosts_, ranks);
  for (Volume* volume : all) completeVolume(*volume, *plan_->partitioning, ranks);
  agree(ranks, [&] {
    for (size_t i = 0; i < volumes.size(); i++) {
      auto dataset = std::make_shared<Dataset>();
      dataset->stream = identity_.name;
      dataset->array = plan_->mesh.fields[i].name;
      dataset->partitioning = plan_->partitioning;
      dataset->volume = volumes[i];
      dataset->origins = {{identity_.id, step.step}};
      dataset->time = step.time;
      dataset->bytes = bytesOf(*volumes[i]);
      dataset->memory = std::move(memory[i]);
      dataset->memory.resize(dataset->bytes);
      publication.stage(i, Payload(std::shared_ptr<const Dataset>(std::move(dataset))));
    }
  });
}

}  // namespace gxy
