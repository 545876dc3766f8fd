// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/streams.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "multiserver/server/datasets.h"

namespace gxy {

using nlohmann::json;
using protocol::MessageChannel;

namespace {

insitu::Ticket newTicket() {
  std::random_device random;
  insitu::Ticket ticket;
  for (uint8_t& byte : ticket) byte = uint8_t(random());
  return ticket;
}

std::string hexadecimal(const insitu::Ticket& ticket) {
  std::string text;
  for (const uint8_t byte : ticket) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", byte);
    text += two;
  }
  return text;
}

std::string hostName() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

// A rank of a simulation, on one rank of the server. `lead` is null on other ranks than 0.
class Taker final : public DataTaker {
 public:
  Taker(int rank, insitu::Checksum checksum, std::shared_ptr<StreamPart> part,
        std::shared_ptr<StreamLead> lead)
      : rank_(rank), checksum_(checksum), part_(std::move(part)), lead_(std::move(lead)) {}

  protocol::MessageReader::Rules rules() const override {
    return lead_ ? protocol::MessageReader::ofDataToRoot() : protocol::MessageReader::ofDataToOthers();
  }
  void take(const protocol::WireMessage& message) override {
    if (message.channel == MessageChannel::Piece) return part_->takePiece(rank_, checksum_, message.payload);
    lead_->take(rank_, message);  // The rules let other ranks have samples only.
  }
  void ended(const std::string& reason, bool regularly) override {
    part_->disconnect(rank_, reason, regularly);
    if (lead_ && regularly) lead_->closed(rank_);
  }

 private:
  const int rank_;
  const insitu::Checksum checksum_;
  const std::shared_ptr<StreamPart> part_;
  const std::shared_ptr<StreamLead> lead_;
};

}  // namespace

Streams::Streams(ServerRank& serverRank, const AddWork& addWork) : serverRank_(serverRank) {
  const auto add = [&](const char* name, json (Streams::*action)(const json&), Work::Runs runs) {
    addWork(
        name, [this, action](const Work::Call& call) { return (this->*action)(call.parameters); }, runs);
  };
  add("insitu.open", &Streams::openHere, Work::Runs::Short);
  add("insitu.step", &Streams::stepHere, Work::Runs::Waiting);
  add("insitu.end", &Streams::endHere, Work::Runs::Waiting);
  addWork(
      "insitu.plan",
      [this](const Work::Call& call) -> json {
        part(call.parameters.at("stream").get<uint64_t>())->plan(readPlan(call.attachment));
        return nullptr;
      },
      Work::Runs::Waiting);
  addWork(
      "insitu.complete",
      [this](const Work::Call& call) -> json {
        if (const auto lead = this->lead(call.parameters.at("stream").get<uint64_t>()))
          lead->complete(call.sender, call.parameters.at("count").get<uint64_t>(),
                         call.parameters.at("bytes").get<uint64_t>());
        return nullptr;
      },
      Work::Runs::Short);
  addWork(
      "insitu.refused",
      [this](const Work::Call& call) -> json {
        if (const auto lead = this->lead(call.parameters.at("stream").get<uint64_t>()))
          lead->refused(call.parameters.at("count").get<uint64_t>(),
                        call.parameters.at("reason").get<std::string>());
        return nullptr;
      },
      Work::Runs::Short);
  addWork(
      "insitu.lost",
      [this](const Work::Call& call) -> json {
        if (const auto lead = this->lead(call.parameters.at("stream").get<uint64_t>()))
          lead->end(call.parameters.at("reason").get<std::string>());
        return nullptr;
      },
      Work::Runs::Short);
  if (serverRank_.rank() != 0) return;
  serverRank_.streaming.set([this] { return list({}); }, [this] { endAll(); });
}

Streams::~Streams() {
  if (serverRank_.rank() == 0) serverRank_.streaming.reset();
}

std::shared_ptr<StreamPart> Streams::part(uint64_t stream) const {
  const std::lock_guard lock(mutex_);
  const auto at = parts_.find(stream);
  if (at == parts_.end()) throw Error("the stream has ended");
  return at->second;
}

std::shared_ptr<StreamLead> Streams::lead(uint64_t stream) const {
  const std::lock_guard lock(mutex_);
  const auto at = leads_.find(stream);
  return at == leads_.end() ? nullptr : at->second;
}

std::shared_ptr<StreamLead> Streams::leadOf(const std::string& tenant, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, lead] : leads_)
    if (lead->identity().tenant == tenant && lead->identity().name == name && !lead->ending()) return lead;
  return nullptr;
}

json Streams::openHere(const json& p) {
  StreamIdentity identity{p.at("stream").get<uint64_t>(), p.at("name").get<std::string>(),
                          p.at("tenant").get<std::string>(), p.at("ticket").get<insitu::Ticket>(),
                          p.at("ranks").get<int>()};
  const uint64_t id = identity.id;
  const auto tellRoot = [this, id](const char* work, json what) {
    what["stream"] = id;
    serverRank_.work.send(0, work, what, [](std::vector<Work::Reply>) {});
  };
  StreamPart::Tell tell{[tellRoot](uint64_t count, uint64_t bytes) {
                          tellRoot("insitu.complete", {{"count", count}, {"bytes", bytes}});
                        },
                        [tellRoot](uint64_t count, const std::string& reason) {
                          tellRoot("insitu.refused", {{"count", count}, {"reason", reason}});
                        },
                        [tellRoot](const std::string& reason) {
                          tellRoot("insitu.lost", {{"reason", reason}});
                        }};
  const std::lock_guard lock(mutex_);
  if (!port_)
    port_ = std::make_unique<DataPort>(serverRank_.options.insituBind,
                                       [this](const insitu::Hello& hello, std::shared_ptr<DataLink> link) {
                                         return admit(hello, std::move(link));
                                       });
  parts_.emplace(id, std::make_shared<StreamPart>(serverRank_, std::move(identity), std::move(tell)));
  return {{"host", hostName()}, {"port", port_->port()}};
}

std::shared_ptr<DataTaker> Streams::admit(const insitu::Hello& hello, std::shared_ptr<DataLink> link) {
  std::shared_ptr<StreamPart> part;
  std::shared_ptr<StreamLead> lead;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, candidate] : parts_)
      if (candidate->shows(hello)) part = candidate;
    if (part && serverRank_.rank() == 0) {
      const auto at = leads_.find(part->identity().id);
      if (at == leads_.end()) return nullptr;
      lead = at->second;
    }
  }
  const int rank = int(hello.rank);
  if (!part || !part->connect(rank, std::move(link), hello.checksum)) return nullptr;
  return std::make_shared<Taker>(rank, hello.checksum, std::move(part), std::move(lead));
}

json Streams::stepHere(const json& p) {
  const auto id = p.at("stream").get<uint64_t>(), exchange = p.at("exchange").get<uint64_t>();
  Exchanges::Part underWay = serverRank_.exchanges.join(exchange);
  RankCollectives& ranks = underWay.ranks;
  Publication publication = serverRank_.datasets->join(p.at("items"), ranks);
  std::shared_ptr<StreamPart> mine;
  agree(ranks, [&] { mine = part(id); });
  const std::shared_ptr<StreamLead> leading = lead(id);  // null on other ranks than 0
  insitu::Encodings encodings;
  for (const json& e : p.at("encodings"))
    encodings.push_back(
        {e.at(0).get<uint32_t>(), e.at(1).get<uint32_t>(), e.at(2).get<double>(), e.at(3).get<double>()});
  mine->step(
      publication, exchange, underWay, encodings,
      [&] {
        if (!leading) throw Error("the stream has ended");
        return leading->collect([&] { ranks.check(); });
      },
      [&] { return leading ? leading->lastAppointed() : 0; });
  return nullptr;
}

json Streams::endHere(const json& p) {
  std::shared_ptr<StreamPart> gone;
  std::unique_ptr<DataPort> port;
  {
    const std::lock_guard lock(mutex_);
    const auto at = parts_.find(p.at("stream").get<uint64_t>());
    if (at == parts_.end()) return nullptr;
    gone = at->second;
    parts_.erase(at);
    if (parts_.empty()) port = std::move(port_);
  }
  gone->end(p.at("reason").get<std::string>());
  return nullptr;  // The port closes without the lock, since its thread may wait for that.
}

void Streams::begin(const std::string& tenant, const Join& what) {
  if (stopped_) throw Error("insitu.join: the server stops");
  std::vector<std::shared_ptr<StreamLead>> over;  // to be destroyed without the lock
  size_t ofTenant = 0;
  {
    const std::lock_guard lock(mutex_);
    over.swap(over_);
    for (const auto& [id, lead] : leads_) ofTenant += lead->identity().tenant == tenant;
  }
  if (ofTenant >= kOfTenant)
    throw Error("insitu.join: tenant " + tenant + " has " + std::to_string(kOfTenant) +
                " streams, no more are allowed");
  const StreamIdentity identity{serverRank_.keys.next().value, what.name, tenant, newTicket(), what.ranks};
  try {
    const std::vector<json> opened = serverRank_.callAll("insitu.open", {{"stream", identity.id},
                                                                         {"name", identity.name},
                                                                         {"tenant", tenant},
                                                                         {"ticket", identity.ticket},
                                                                         {"ranks", identity.ranks}});
    json ports = json::array();
    for (const json& one : opened) {  // An empty host means the one at which the simulation has found rank 0.
      const bool beside = one.at("host") == opened.front().at("host");
      ports.push_back({{"host", beside ? json("") : one.at("host")}, {"port", one.at("port")}});
    }
    const std::lock_guard lock(mutex_);  // so that the lead, if it ends at once, finds itself
    ports_.emplace(identity.id, std::move(ports));
    leads_.emplace(identity.id, std::make_shared<StreamLead>(
                                    serverRank_, parts_.at(identity.id), what.wishes,
                                    [this, tenant](const json& event) { tell(tenant, event); },
                                    [this, id = identity.id] { ended(id); }));
  } catch (const std::exception& e) {
    serverRank_.work.broadcast("insitu.end", {{"stream", identity.id}, {"reason", e.what()}},
                               [](std::vector<Work::Reply>) {});
    throw;
  }
}

json Streams::join(const std::string& tenant, const Join& what) {
  const std::lock_guard joining(joining_);
  auto lead = leadOf(tenant, what.name);
  if (lead && lead->identity().ranks == what.ranks && lead->isConnected(what.rank))
    throw Error("insitu.join: rank " + std::to_string(what.rank) + " of stream " + inQuotes(what.name) +
                " is connected already; two simulations cannot have one name");
  if (!lead) {
    begin(tenant, what);
    lead = leadOf(tenant, what.name);
    if (!lead) throw Error("insitu.join: the stream has ended at once");
  }
  const StreamIdentity& identity = lead->identity();
  if (identity.ranks != what.ranks || !(lead->wishes() == what.wishes))
    throw Error(
        "insitu.join: stream " + inQuotes(what.name) + " has " + std::to_string(identity.ranks) +
        " ranks, or other options; expected the same on all ranks of the simulation, or another name");
  for (const Trigger& trigger : what.triggers) lead->triggers().add(trigger);
  const std::lock_guard lock(mutex_);
  const auto ports = ports_.find(identity.id);
  if (ports == ports_.end()) throw Error("insitu.join: the stream has ended at once");
  return {{"stream", identity.id},
          {"ticket", hexadecimal(identity.ticket)},
          {"ranks", ports->second},
          {"text", "stream " + what.name}};
}

json Streams::list(const std::string& tenant) const {
  std::vector<std::shared_ptr<StreamLead>> leads;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, lead] : leads_)
      if (tenant.empty() || lead->identity().tenant == tenant) leads.push_back(lead);
  }
  json list = json::array();
  for (const auto& lead : leads) list.push_back(lead->statistics());
  return list;
}

void Streams::close(const std::string& tenant, const std::string& name) {
  const auto lead = leadOf(tenant, name);
  if (!lead)
    throw Error("insitu.close: there is no stream " + inQuotes(name) + "; `insitu.streams` lists them");
  lead->end("closed by a client");
}

void Streams::steer(const std::string& tenant, const std::string& name, const insitu::Steering& values) {
  const auto lead = leadOf(tenant, name);
  if (!lead) throw Error("there is no stream " + inQuotes(name) + "; `insitu.streams` lists them");
  lead->steer(values);
}

void Streams::withTriggers(const std::string& tenant, const std::string& name,
                           const std::function<void(Triggers&)>& action) {
  const auto lead = leadOf(tenant, name);
  if (!lead) throw Error("there is no stream " + inQuotes(name) + "; `insitu.streams` lists them");
  action(lead->triggers());
}

std::shared_ptr<void> Streams::listen(const std::string& tenant, std::shared_ptr<Outbox> outbox) {
  const auto listener = std::make_shared<Listener>(Listener{tenant, std::move(outbox)});
  const std::lock_guard lock(mutex_);
  std::erase_if(listeners_, [](const auto& l) { return l.expired(); });
  listeners_.push_back(listener);
  return listener;
}

void Streams::tell(const std::string& tenant, const json& event) {
  std::vector<std::shared_ptr<Listener>> listeners;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& l : listeners_)
      if (auto listener = l.lock(); listener && listener->tenant == tenant)
        listeners.push_back(std::move(listener));
  }
  for (const auto& l : listeners) l->outbox->event(event);
}

// On the lead's own thread, which cannot destroy it.
void Streams::ended(uint64_t stream) {
  const std::lock_guard lock(mutex_);
  const auto at = leads_.find(stream);
  if (at == leads_.end()) return;
  over_.push_back(std::move(at->second));
  leads_.erase(at);
  ports_.erase(stream);
}

void Streams::endAll() {
  const std::lock_guard joining(joining_);
  stopped_ = true;
  std::vector<std::shared_ptr<StreamLead>> all;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, lead] : leads_) all.push_back(lead);
    all.insert(all.end(), over_.begin(), over_.end());
  }
  for (const auto& lead : all) lead->stop("the server stops");
  for (const auto& lead : all) lead->join();
}

}  // namespace gxy
