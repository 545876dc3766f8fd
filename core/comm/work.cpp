// SPDX-License-Identifier: Apache-2.0
#include "core/comm/work.h"

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
                    std::span<const std::byte> attachment, bool toAll, size_t expected, OnDone onDone) {
  std::lock_guard lock(mutex_);
  const uint64_t id = nextId_++;
  Writer writer;
  writer.write(MessageKind::Message).write(id).write(int32_t(transport_.rank())).write(toAll);
  writer.write(name).write(dumpJson(parameters)).write(attachment);
  pending_[id] = {expected, {}, std::move(onDone)};
  return writer.take();
}

void Work::send(int rank, const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                std::span<const std::byte> attachment) {
  if (rank < 0 || rank >= transport_.size())
    throw Error("work '" + name + "' for rank " + std::to_string(rank) + ", expected 0 to " +
                std::to_string(transport_.size() - 1));
  transport_.send(rank, Channel::Work, request(name, parameters, attachment, false, 1, std::move(onDone)));
}

void Work::broadcast(const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                     std::span<const std::byte> attachment) {
  transport_.send(transport_.rank(), Channel::Work,
                  request(name, parameters, attachment, true, size_t(transport_.size()), std::move(onDone)));
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
  if (request.toAll)
    forEachTreeChild(transport_.rank(), request.sender, transport_.size(),
                     [&](int child) { transport_.send(child, Channel::Work, message); });
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
  Writer writer;
  writer.write(MessageKind::Reply).write(request.id).write(error).write(dumpJson(result));
  transport_.send(request.sender, Channel::Work, writer.take());
}

void Work::receiveReply(int source, const Bytes& message) {
  Reader reader(message, "work reply");
  reader.read<MessageKind>();
  const auto id = reader.read<uint64_t>();
  Reply reply{source, nullptr, {}};
  try {
    reply.error = reader.readString();
    reply.result = parseJson(reader.readString());
    reader.expectEnd();
  } catch (const std::exception& error) {
    reply.error = error.what();
  }
  if (!reply.ok()) reply.error = "rank " + std::to_string(source) + ": " + reply.error;

  std::unique_lock lock(mutex_);
  const auto found = pending_.find(id);
  if (found == pending_.end())
    throw Error("rank " + std::to_string(source) + " replied to work " + std::to_string(id) +
                ", which this rank does not wait for");
  found->second.replies[source] = std::move(reply);
  if (found->second.replies.size() < found->second.expected) return;
  const auto done = std::make_shared<Pending>(std::move(pending_.extract(found).mapped()));
  lock.unlock();
  startTask(Runs::Short, [done] {
    std::vector<Reply> replies;
    for (auto& [rank, reply] : done->replies) replies.push_back(std::move(reply));
    if (done->onDone) done->onDone(std::move(replies));
  });
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
