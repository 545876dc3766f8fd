// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/session.h"

#include <algorithm>
#include <optional>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/statement.h"
#include "multiserver/server/module.h"
#include "multiserver/server/server_verbs.h"

namespace gxy {

Request::Request(Session& session, uint32_t id, Bytes text)
    : session_(session), id_(id), bytes_(text.size()), text_(std::move(text)) {}

void Request::read() {
  const Bytes taken = std::exchange(text_, {});
  if (!verb_.empty()) return;
  const std::string_view text(reinterpret_cast<const char*>(taken.data()), taken.size());
  if (!protocol::isUtf8(text)) throw Error("statement: its text is not UTF-8");
  protocol::Statement statement = protocol::parseStatement(text);
  verb_ = std::move(statement.verb);
  arguments_ = std::move(statement.arguments);
}

void Request::check() const {
  if (cancelled_) throw Error("cancelled");
}

void Request::onCancel(std::function<void()> action) {
  {
    const std::lock_guard lock(mutex_);
    if (!cancelled_) return cancelActions_.push_back(std::move(action));
  }
  action();
}

void Request::cancel() {
  std::vector<std::function<void()>> actions;
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    actions.swap(cancelActions_);
  }
  for (const auto& action : actions) action();
}

void Request::onAnswered(std::function<void()> action) {
  const std::lock_guard lock(mutex_);
  answeredActions_.push_back(std::move(action));
}

void Request::progress(int64_t done, int64_t of, const std::string& text, bool phase) {
  {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (done < of && !phase && now < lastProgress_ + std::chrono::milliseconds(100)) return;
    lastProgress_ = now;
  }
  session_.outbox().event(
      {{"event", "progress"}, {"request", id_}, {"done", done}, {"of", of}, {"text", text}});
}

Session::Session(ServerRank& serverRank, std::shared_ptr<Outbox> outbox, Identity identity,
                 protocol::Limits limits)
    : serverRank_(serverRank), outbox_(std::move(outbox)), identity_(std::move(identity)), limits_(limits) {}

Session::~Session() = default;

void Session::expectMayChange(const std::string& what) const {
  if (identity_.viewOnly)
    throw Error(what +
                ": it changes something, and this session has a view-only token, expected the tenant's own");
}

bool Session::makeRoom(uint64_t bytes) {
  constexpr uint64_t kShort = 4096;  // enough for statements that free memory
  incoming_ = {};
  if (bytes <= kShort) return true;
  try {
    incoming_ = serverRank_.takeMemory(tenant(), "requests", int64_t(bytes));
    return true;
  } catch (const Error& e) {
    noRoom_ = e.what();
    return false;
  }
}

void Session::refuse(uint32_t id) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    checkId(id);
  }
  outbox_->reply(id, "error: " + protocol::printable(noRoom_));
}

void Session::checkId(uint32_t id) const {
  if (id == 0 || requests_.count(id) > 0)
    throw Error("request with id " + std::to_string(id) + ", which is 0 or not answered yet");
}

void Session::submit(uint32_t id, Bytes text) {
  constexpr size_t kLong = 64 << 10;  // Longer ones are parsed in their turn, not on the sockets' thread.
  const auto request = std::make_shared<Request>(*this, id, std::move(text));
  std::string wrong;
  const Verb* atOnce = nullptr;
  try {
    if (request->bytes() <= kLong) {
      request->read();
      atOnce = serverVerb(request->verb());
      if (atOnce && atOnce->order != Order::AtOnce) atOnce = nullptr;
    }
  } catch (const Error& e) {
    wrong = e.what();
  }
  request->memory_ = std::exchange(incoming_, {});
  if (request->memory_.bytes() == 0)
    request->memory_ = serverRank_.ledger.enter(tenant(), "requests", int64_t(request->bytes()));
  bool begin = false;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    checkId(id);
    requests_[id] = request;
    requestBytes_ += request->bytes();
    if (wrong.empty() && !atOnce) {
      queue_.push_back(request);
      begin = !std::exchange(running_, true);
    }
  }
  if (!wrong.empty()) return answerError(request, wrong);
  if (atOnce) return run(request, atOnce->action);
  if (begin) serverRank_.transport.postWaiting([self = shared_from_this()] { self->runNext(); });
}

// Runs queued requests until the queue is empty.
void Session::runNext() {
  for (;;) {
    RequestPtr request;
    {
      const std::lock_guard lock(mutex_);
      if (queue_.empty()) {
        running_ = false;
        answered_.notify_all();
        return;
      }
      request = std::move(queue_.front());
      queue_.pop_front();
    }
    try {
      request->check();
      request->read();
      const Verb& verb = resolveVerb(*this, request->verb());
      if (verb.effect == Effect::Changes) expectMayChange(verb.name);
      if (verb.order == Order::Aside)
        startAside(request, verb.action);
      else
        run(request, verb.action);
    } catch (const std::exception& e) {
      answerError(request, e.what());
    }
  }
}

void Session::startAside(const RequestPtr& request, std::function<nlohmann::json(Request&)> action) {
  std::shared_ptr<void> slot;
  {
    std::unique_lock lock(mutex_);
    answered_.wait(lock, [&] { return aside_ < kAside || request->cancelled(); });
    request->check();
    slot = serverRank_.tenants.beginAside(tenant());
    aside_++;
  }
  const std::shared_ptr<void> left(nullptr, [self = shared_from_this(), slot](void*) {
    const std::lock_guard lock(self->mutex_);
    self->aside_--;
    self->answered_.notify_all();
  });
  serverRank_.transport.postWaiting(
      [self = shared_from_this(), request, left, action = std::move(action)] { self->run(request, action); });
}

void Session::run(const RequestPtr& request, const std::function<nlohmann::json(Request&)>& action) {
  const Trace::Span span(serverRank_.options.trace, request->verb(), identity_.number);
  std::string text;
  std::optional<std::string> error;
  try {
    request->check();
    const nlohmann::json result = action(*request);
    if (!result.is_null() && !result.is_object())
      throw Error(request->verb() + " returned no object: its result is " + result.type_name() +
                  ", expected an object or nothing");
    text = result.is_null() ? "ok" : "ok " + protocol::dump(result);
  } catch (const std::exception& e) {
    error = request->cancelled() ? "cancelled" : e.what();
  } catch (...) {
    error = request->verb() + " failed with an exception that is no std::exception";
  }
  if (error)
    answerError(request, *error);
  else
    answer(request, text);
}

// Messages are made printable, because they may quote the content of files.
void Session::answerError(const RequestPtr& request, const std::string& message) {
  answer(request, "error: " + protocol::printable(message));
}

void Session::answer(const RequestPtr& request, const std::string& text) {
  {
    const std::lock_guard lock(mutex_);
    requests_.erase(request->id());
    requestBytes_ -= request->bytes();
    request->memory_ = {};
  }
  outbox_->reply(request->id(), text);
  if (onAnswered) onAnswered();
  for (const auto& action : request->answeredActions_) action();
  const std::lock_guard lock(mutex_);
  answered_.notify_all();
}

size_t Session::unanswered() const {
  const std::lock_guard lock(mutex_);
  return requests_.size();
}

bool Session::full() const {
  const std::lock_guard lock(mutex_);
  return requests_.size() >= limits_.requests || requestBytes_ > 2 * limits_.requestBytes;
}

void Session::cancel(uint32_t id) {
  RequestPtr request;
  bool waits = false;
  {
    const std::lock_guard lock(mutex_);
    const auto found = requests_.find(id);
    if (found == requests_.end()) return;
    request = found->second;
    waits = std::erase(queue_, request) > 0;
  }
  request->cancel();
  if (waits) return answerError(request, "cancelled");
  const std::lock_guard lock(mutex_);  // startAside() may be waiting with it
  answered_.notify_all();
}

void Session::tellMissing(const std::vector<Presence::Missing>& missing) {
  std::vector<int> ranks;
  for (const auto& m : missing) ranks.push_back(m.rank);
  std::set<uint32_t> requests;
  {
    const std::lock_guard lock(mutex_);
    if (!ranks.empty())
      for (const auto& [id, request] : requests_) requests.insert(id);
    const bool more =
        !std::includes(toldRequests_.begin(), toldRequests_.end(), requests.begin(), requests.end());
    if (ranks == toldRanks_ && !more) return;
    toldRanks_ = ranks;
    toldRequests_ = requests;
  }
  outbox_->event({{"event", "waiting"},
                  {"ranks", ranks},
                  {"requests", requests},
                  {"text", ranks.empty() ? "all ranks answer again" : textOf(missing)}});
}

void Session::end() {
  std::map<uint32_t, RequestPtr> requests;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    requests = requests_;
  }
  for (const auto& [id, request] : requests) request->cancel();
  requests.clear();
  std::map<std::type_index, std::shared_ptr<void>> states;
  std::unique_lock lock(mutex_);
  answered_.notify_all();
  answered_.wait(lock, [this] { return requests_.empty() && !running_ && aside_ == 0; });
  states.swap(states_);
  lock.unlock();
}

std::shared_ptr<void> Session::stateOf(std::type_index type,
                                       const std::function<std::shared_ptr<void>()>& make) {
  const std::lock_guard lock(mutex_);
  const auto found = states_.find(type);
  if (found != states_.end() || !make) return found == states_.end() ? nullptr : found->second;
  return states_[type] = make();
}

std::vector<std::shared_ptr<const LoadedModule>> Session::modules() const {
  const std::lock_guard lock(mutex_);
  return modules_;
}

void Session::addModule(std::shared_ptr<const LoadedModule> module) {
  const std::lock_guard lock(mutex_);
  for (const auto& m : modules_)
    if (m == module) return;
  modules_.push_back(std::move(module));
}

}  // namespace gxy
