// SPDX-License-Identifier: Apache-2.0
#include "core/comm/work.h"

#include <algorithm>
#include <condition_variable>
#include <future>
#include <memory>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

enum class MessageKind : uint8_t { Message, Reply };

/// Deeper documents are refused, because parsing them is recursive.
constexpr int maxDepth = 200;

nlohmann::json parseJson(const std::string& text) {
  const auto checkDepth = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > maxDepth)
      throw Error("a document is nested too deeply, expected at most " + std::to_string(maxDepth) +
                  " levels");
    return true;
  };
  return nlohmann::json::parse(text, checkDepth);
}

std::string dumpJson(const nlohmann::json& document) {
  return document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

/// Lets tasks enter until it is closed, and counts those inside. close() waits until none is inside.
class Work::Gate {
 public:
  bool enter() {
    std::lock_guard lock(mutex_);
    if (!closed_) ++inside_;
    return !closed_;
  }
  void leave() {
    std::lock_guard lock(mutex_);
    if (--inside_ == 0) empty_.notify_all();
  }
  void close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    empty_.wait(lock, [this] { return inside_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable empty_;
  size_t inside_ = 0;
  bool closed_ = false;
};

/// A request as it arrived.
struct Work::Message {
  uint64_t id;
  int32_t sender;
  bool toAll;
  std::string name, parameters;
  std::vector<std::byte> attachment;
};

Work::Work(Transport& transport, Trace* trace)
    : transport_(transport), trace_(trace), gate_(std::make_shared<Gate>()) {
  transport_.onMessage(Channel::Work,
                       [this](int source, Bytes message) { receive(source, std::move(message)); });
}

Work::~Work() {
  transport_.onMessage(Channel::Work, nullptr);
  gate_->close();
}

void Work::add(const std::string& name, Action action, Runs runs) {
  std::lock_guard lock(mutex_);
  if (!actions_.emplace(name, Registered{std::move(action), runs}).second)
    throw Error("work '" + name + "' is registered twice");
}

bool Work::contains(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return actions_.count(name) > 0;
}

Work::Runs Work::runsOf(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = actions_.find(name);
  if (found == actions_.end()) throw Error("no work named '" + name + "' is registered");
  return found->second.runs;
}

// -----------------------------------------------------------------------------------------------------------
// sending

Bytes Work::request(const std::string& name, const nlohmann::json& parameters,
                    std::span<const std::byte> attachment, bool toAll, OnDone onDone) {
  std::lock_guard lock(mutex_);
  const uint64_t id = nextId_++;
  Writer writer;
  writer.write(MessageKind::Message).write(id).write(int32_t(transport_.rank())).write(toAll);
  writer.write(name).write(dumpJson(parameters)).write(attachment);
  pending_[id] = std::move(onDone);
  return writer.take();
}

void Work::send(int rank, const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                std::span<const std::byte> attachment) {
  if (rank < 0 || rank >= transport_.size())
    throw Error("work '" + name + "' for rank " + std::to_string(rank) + ", expected 0 to " +
                std::to_string(transport_.size() - 1));
  transport_.send(rank, Channel::Work, request(name, parameters, attachment, false, std::move(onDone)));
}

void Work::broadcast(const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                     std::span<const std::byte> attachment) {
  transport_.send(transport_.rank(), Channel::Work,
                  request(name, parameters, attachment, true, std::move(onDone)));
}

nlohmann::json Work::call(int rank, const std::string& name, const nlohmann::json& parameters,
                          std::span<const std::byte> attachment) {
  return wait([&](OnDone onDone) { send(rank, name, parameters, std::move(onDone), attachment); }).front();
}

std::vector<nlohmann::json> Work::callAll(const std::string& name, const nlohmann::json& parameters,
                                          std::span<const std::byte> attachment) {
  return wait([&](OnDone onDone) { broadcast(name, parameters, std::move(onDone), attachment); });
}

std::vector<nlohmann::json> Work::wait(const std::function<void(OnDone)>& start) {
  const auto promise = std::make_shared<std::promise<std::vector<Reply>>>();
  start([promise](std::vector<Reply> replies) { promise->set_value(std::move(replies)); });
  std::vector<nlohmann::json> results;
  std::string errors;
  for (auto& reply : promise->get_future().get()) {
    if (!reply.ok()) errors += (errors.empty() ? "" : "; ") + reply.error;
    results.push_back(std::move(reply.result));
  }
  if (!errors.empty()) throw Error(errors);
  return results;
}

// ---------------------------------------------------------------------------------------------------------
// receiving

void Work::receive(int source, Bytes message) {
  switch (Reader(message, "work").read<MessageKind>()) {
    case MessageKind::Message:
      return receiveRequest(std::move(message));
    case MessageKind::Reply:
      return receiveReply(source, message);
  }
  throw Error("malformed message 'work' from rank " + std::to_string(source) + ": neither request nor reply");
}

void Work::receiveRequest(Bytes message) {
  Message request;
  Reader reader(message, "work request");
  reader.read<MessageKind>();
  request.id = reader.read<uint64_t>();
  request.sender = reader.read<int32_t>();
  request.toAll = reader.read<bool>();
  if (request.sender < 0 || request.sender >= transport_.size())
    reader.fail("its sender is rank " + std::to_string(request.sender) + ", expected 0 to " +
                std::to_string(transport_.size() - 1));
  if (request.toAll) {
    std::set<int> missing{transport_.rank()};
    forEachTreeChild(transport_.rank(), request.sender, transport_.size(),
                     [&](int child) { missing.insert(child); });
    {
      std::lock_guard lock(mutex_);
      if (!gatherings_.emplace(CallId(request.sender, request.id), Gathering{std::move(missing), {}}).second)
        reader.fail("it came twice");
    }
    forEachTreeChild(transport_.rank(), request.sender, transport_.size(),
                     [&](int child) { transport_.send(child, Channel::Work, message); });
  }
  // From here on the sender is known, so errors become replies.
  try {
    request.name = reader.readString();
    request.parameters = reader.readString();
    request.attachment = reader.readVector<std::byte>();
    reader.expectEnd();
    std::unique_lock lock(mutex_);
    const auto found = actions_.find(request.name);
    if (found == actions_.end()) throw Error("no work named '" + request.name + "' is registered");
    const Registered registered = found->second;
    lock.unlock();
    startTask(registered.runs, [this, request = std::make_shared<Message>(std::move(request)),
                                action = registered.action] { run(*request, action); });
  } catch (const std::exception& error) {
    reply(request, nullptr, error.what());
  }
}

void Work::run(const Message& request, const Action& action) {
  const Trace::Span span(trace_, request.name, request.parameters.size());
  nlohmann::json result;
  std::string error;
  try {
    const auto parameters = parseJson(request.parameters);
    result = action({request.sender, parameters, request.attachment});
  } catch (const std::exception& exception) {
    error = exception.what();
    if (error.empty()) error = "failed without a message";
  } catch (...) {
    error = "failed with an exception that is no std::exception";
  }
  reply(request, error.empty() ? result : nullptr, error);
}

void Work::reply(const Message& request, const nlohmann::json& result, const std::string& error) {
  const CallId call(request.sender, request.id);
  Replies mine{{{error, dumpJson(result)}, {transport_.rank()}}};
  if (request.toAll)
    gather(call, transport_.rank(), std::move(mine));
  else
    sendReplies(request.sender, call, false, mine);
}

// Adds replies to those that have come. Once all are there, they go up the tree.
void Work::gather(CallId call, int source, Replies replies) {
  {
    std::lock_guard lock(mutex_);
    const auto found = gatherings_.find(call);
    if (found == gatherings_.end() || found->second.missing.erase(source) == 0)
      throw Error("replies of rank " + std::to_string(source) + " came to work " +
                  std::to_string(call.second) + " of rank " + std::to_string(call.first) +
                  ", which this rank does not wait for");
    for (auto& [said, ranks] : replies) {
      std::vector<int32_t>& all = found->second.replies[said];
      all.insert(all.end(), ranks.begin(), ranks.end());
    }
    if (!found->second.missing.empty()) return;
    replies = std::move(gatherings_.extract(found).mapped().replies);
  }
  const int parent = treeParent(transport_.rank(), call.first, transport_.size());
  if (parent < 0)
    conclude(call.second, replies);
  else
    sendReplies(parent, call, true, replies);
}

void Work::sendReplies(int destination, CallId call, bool toAll, const Replies& replies) {
  Writer writer;
  writer.write(MessageKind::Reply).write(int32_t(call.first)).write(call.second).write(toAll);
  for (const auto& [said, ranks] : replies) writer.write(said.first).write(said.second).write(ranks);
  transport_.send(destination, Channel::Work, writer.take());
}

void Work::receiveReply(int source, const Bytes& message) {
  Reader reader(message, "work reply");
  reader.read<MessageKind>();
  const auto sender = reader.read<int32_t>();
  const auto id = reader.read<uint64_t>();
  const auto toAll = reader.read<bool>();
  const int me = transport_.rank(), size = transport_.size();
  if (sender < 0 || sender >= size || (toAll ? treeParent(source, sender, size) : sender) != me)
    reader.fail("rank " + std::to_string(source) + " has none to send here for a work of rank " +
                std::to_string(sender));
  std::vector<int32_t> ranks;
  if (toAll)
    forEachInSubtree(source, sender, size, [&](int rank) { ranks.push_back(rank); });
  else
    ranks.push_back(source);
  Replies replies;
  // From here on it is known who waits for whose replies, so what is wrong becomes an error of these ranks.
  try {
    replies = readReplies(reader, ranks);
  } catch (const std::exception& error) {
    replies = {{{"its reply came by rank " + std::to_string(source) + ": " + error.what(), "null"}, ranks}};
  }
  if (toAll)
    gather({sender, id}, source, std::move(replies));
  else
    conclude(id, replies);
}

// Reads the replies of so many ranks, each of which has one.
Work::Replies Work::readReplies(Reader& reader, std::vector<int32_t> expected) {
  Replies replies;
  std::vector<int32_t> came;
  while (!reader.rest().empty()) {
    std::string error = reader.readString(), result = reader.readString();
    const auto ranks = reader.readVector<int32_t>();
    came.insert(came.end(), ranks.begin(), ranks.end());
    std::vector<int32_t>& all = replies[{std::move(error), std::move(result)}];
    all.insert(all.end(), ranks.begin(), ranks.end());
  }
  std::ranges::sort(came);
  std::ranges::sort(expected);
  if (came != expected) reader.fail("it has not one reply of each rank that it should have");
  return replies;
}

// Hands the replies to whoever has called.
void Work::conclude(uint64_t id, const Replies& replies) {
  std::map<int, Reply> byRank;
  for (const auto& [said, ranks] : replies) {
    Reply reply{0, nullptr, said.first};
    try {
      reply.result = parseJson(said.second);
    } catch (const std::exception& error) {
      reply.error = error.what();
    }
    for (const int32_t rank : ranks) {
      Reply& of = byRank[rank] = reply;
      of.rank = rank;
      if (!of.error.empty()) of.error = "rank " + std::to_string(rank) + ": " + of.error;
    }
  }
  OnDone onDone;
  {
    std::lock_guard lock(mutex_);
    const auto found = pending_.find(id);
    if (found == pending_.end())
      throw Error("replies came to work " + std::to_string(id) + ", which this rank does not wait for");
    onDone = std::move(pending_.extract(found).mapped());
  }
  if (!onDone) return;
  const auto all = std::make_shared<std::vector<Reply>>();
  for (auto& [rank, reply] : byRank) all->push_back(std::move(reply));
  startTask(Runs::Short, [onDone = std::move(onDone), all] { onDone(std::move(*all)); });
}

void Work::startTask(Runs runs, Transport::Task task) {
  auto gated = [gate = gate_, task = std::move(task)]() mutable {
    if (!gate->enter()) return;
    const std::shared_ptr<void> leave(nullptr, [&](void*) {
      task = nullptr;
      gate->leave();
    });
    task();
  };
  switch (runs) {
    case Runs::Short:
      return transport_.post(std::move(gated));
    case Runs::Waiting:
      return transport_.postWaiting(std::move(gated));
    case Runs::Long:
      return transport_.postLong(std::move(gated));
  }
}

}  // namespace gxy
