// SPDX-License-Identifier: Apache-2.0
#include "core/comm/presence.h"

#include <algorithm>
#include <utility>

#include "core/comm/wire.h"

namespace gxy {

Presence::Presence(Transport& transport, Options options)
    : transport_(transport), options_(std::move(options)), others_(size_t(transport.size())) {
  transport_.onMessage(kPresenceChannel, [this](int source, Bytes message) { receive(source, message); });
}

Presence::~Presence() { transport_.onMessage(kPresenceChannel, nullptr); }

void Presence::ask() {
  for (int rank = 0; rank < transport_.size(); rank++) {
    if (rank == transport_.rank()) continue;
    {
      const std::lock_guard lock(mutex_);
      if (others_[size_t(rank)].asked) continue;
      others_[size_t(rank)].asked = options_.now();
    }
    send(rank, true);
  }
}

void Presence::send(int rank, bool question) {
  Writer writer;
  writer.write(question).write(options_.process.machine).write(options_.process.number);
  transport_.send(rank, kPresenceChannel, writer.take());
}

void Presence::receive(int source, const Bytes& message) {
  Reader reader(message, "presence");
  const bool question = reader.read<bool>();
  ProcessId process;
  process.machine = reader.readString();
  process.number = reader.read<int32_t>();
  reader.expectEnd();
  {
    const std::lock_guard lock(mutex_);
    Other& other = others_[size_t(source)];
    if (!std::exchange(other.known, true)) other.process = WatchedProcess(process);
    if (!question) other.asked.reset();
  }
  if (question)
    send(source, false);
  else
    changed_.notify_all();
}

std::vector<Presence::Missing> Presence::missing(std::chrono::milliseconds patience) const {
  const auto now = options_.now();
  std::vector<Missing> missing;
  const std::lock_guard lock(mutex_);
  for (size_t rank = 0; rank < others_.size(); rank++) {
    const Other& other = others_[rank];
    const auto since = other.asked ? now - *other.asked : Clock::duration::zero();
    const bool died = other.process.ended();
    if (died || (other.asked && since >= patience))
      missing.push_back({int(rank), died, std::chrono::duration_cast<std::chrono::seconds>(since)});
  }
  return missing;
}

void Presence::answered(std::chrono::milliseconds atMost) const {
  constexpr std::chrono::milliseconds kLook(20);  // The end of a process is not signalled: look for it.
  const auto over = [this] {
    return std::any_of(others_.begin(), others_.end(), [](const Other& o) { return o.process.ended(); }) ||
           std::none_of(others_.begin(), others_.end(), [](const Other& o) { return o.asked.has_value(); });
  };
  const auto end = Clock::now() + atMost;
  std::unique_lock lock(mutex_);
  while (!over() && Clock::now() < end) changed_.wait_for(lock, kLook);
}

bool Presence::died(int rank) const {
  const std::lock_guard lock(mutex_);
  return others_.at(size_t(rank)).process.ended();
}

namespace {

// "rank 1", "ranks 1 and 2", "ranks 1, 2 and 3"
std::string listed(const std::vector<int>& ranks) {
  std::string text = ranks.size() == 1 ? "rank " : "ranks ";
  for (size_t i = 0; i < ranks.size(); i++)
    text += (i == 0 ? "" : i + 1 == ranks.size() ? " and " : ", ") + std::to_string(ranks[i]);
  return text;
}

}  // namespace

std::string textOf(const std::vector<Presence::Missing>& missing) {
  std::vector<int> dead, silent;
  std::chrono::seconds longest{0};
  for (const auto& m : missing) {
    (m.died ? dead : silent).push_back(m.rank);
    if (!m.died) longest = std::max(longest, m.since);
  }
  std::string text;
  if (!dead.empty()) text = listed(dead) + (dead.size() == 1 ? " has died" : " have died");
  if (silent.empty()) return text;
  text += (dead.empty() ? "" : ", ") + listed(silent);
  if (longest.count() == 0) return text + (silent.size() == 1 ? " does not answer" : " do not answer");
  return text + (silent.size() == 1 ? " has not answered for " : " have not answered for ") +
         std::to_string(longest.count()) + " s";
}

}  // namespace gxy
