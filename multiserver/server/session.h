// SPDX-License-Identifier: Apache-2.0
// Runs the requests of one client, in their order and concurrently with those of other clients. Used on rank
// 0. It uses no sockets.
#pragma once
#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <typeindex>
#include <vector>

#include "multiserver/protocol/handshake.h"
#include "multiserver/server/outbox.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

class LoadedModule;
class Session;

/// A statement that a client has sent and that has not been answered. Thread safe.
class Request {
 public:
  Request(Session& session, uint32_t id, Bytes text);

  Session& session() const { return session_; }
  uint32_t id() const { return id_; }
  const std::string& verb() const { return verb_; }
  const std::string& arguments() const { return arguments_; }
  size_t bytes() const { return bytes_; }

  bool cancelled() const { return cancelled_; }
  /// Throws Error "cancelled" if the request is cancelled. Long work calls it often.
  void check() const;
  /// Calls `action` when the request is cancelled, or at once if it is. `action` must be short; any
  /// thread may call it.
  void onCancel(std::function<void()> action);
  void cancel();
  /// Calls `action`, which must be short, once the reply is in the outbox.
  void onAnswered(std::function<void()> action);

  /// Sends a progress event: `done` of `of` units. There are at most ten a second, except that the last one
  /// (done == of) and those that begin a phase are always sent.
  void progress(int64_t done, int64_t of, const std::string& text, bool phase = false);

 private:
  /// Parses the text into verb and arguments, unless that has been done. Called before the action runs.
  /// Throws Error.
  void read();

  Session& session_;
  const uint32_t id_;
  const size_t bytes_;
  Bytes text_;  ///< empty once it has been parsed
  std::string verb_, arguments_;
  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;
  friend class Session;
  LedgerEntry memory_;
  std::vector<std::function<void()>> cancelActions_, answeredActions_;
  std::chrono::steady_clock::time_point lastProgress_{};
};

/// Runs the statements of one connection as requests, on threads of their own (Transport::postWaiting).
/// Requests InTurn run one after the other; at most kAside requests Aside run beside them (module.h). A
/// session never waits for another session.
class Session : public std::enable_shared_from_this<Session> {
 public:
  struct Identity {
    uint64_t number = 0;
    std::string client, tenant;
    bool administrator = false;
    bool viewOnly = false;  ///< may only use verbs that look (module.h)
  };

  static constexpr int kAside = 8;  ///< number of requests Aside that run at once; each occupies a thread

  /// `outbox` is that of the connection. It outlives the session's requests.
  Session(ServerRank& serverRank, std::shared_ptr<Outbox> outbox, Identity identity, protocol::Limits limits);
  ~Session();

  ServerRank& serverRank() const { return serverRank_; }
  Outbox& outbox() const { return *outbox_; }
  const std::shared_ptr<Outbox>& sharedOutbox() const { return outbox_; }
  const Identity& identity() const { return identity_; }
  const std::string& tenant() const { return identity_.tenant; }
  const protocol::Limits& limits() const { return limits_; }
  /// Throws Error if the session is view-only. `what` begins the message.
  void expectMayChange(const std::string& what) const;

  /// Takes memory for a statement of this size that is about to come. Short statements (4096 bytes) always
  /// get it. Returns false if there is none: then the statement must be passed to refuse() instead of
  /// submit(). One thread at a time may call this and the next two functions.
  bool makeRoom(uint64_t bytes);
  /// Takes a statement. Its reply goes to the outbox. Throws Error if the id is 0 or in use, which breaks the
  /// protocol.
  void submit(uint32_t id, Bytes text);
  /// Answers the statement for which there was no memory with an error. Throws as submit() does.
  void refuse(uint32_t id);
  size_t unanswered() const;
  /// Whether no more statements should be read: limits.requests are unanswered, or the unanswered ones have
  /// more than twice limits.requestBytes.
  bool full() const;

  /// Cancels the request with this id, if there is one. A request that has not begun is answered at once.
  void cancel(uint32_t id);

  /// Sends an event that says which ranks do not answer and which of the client's requests are unanswered
  /// meanwhile. It is sent again when the ranks change or there are new requests, and once when all ranks
  /// answer again.
  void tellMissing(const std::vector<Presence::Missing>& missing);

  /// Cancels all requests, waits for them to end, and drops the modules' states. Later statements are
  /// ignored. It may be called more than once, but not from a handler.
  void end();

  /// Returns the module's object of type T for this session, and makes it at the first call. It is destroyed
  /// when the session ends.
  template <class T>
  std::shared_ptr<T> state(const std::function<std::shared_ptr<T>()>& make) {
    return std::static_pointer_cast<T>(stateOf(typeid(T), [&]() -> std::shared_ptr<void> { return make(); }));
  }
  /// Returns the object of type T, or null.
  template <class T>
  std::shared_ptr<T> stateIfAny() {
    return std::static_pointer_cast<T>(stateOf(typeid(T), nullptr));
  }

  /// The modules of this session, in the order in which the client loaded them.
  std::vector<std::shared_ptr<const LoadedModule>> modules() const;
  void addModule(std::shared_ptr<const LoadedModule> module);

  /// Called from any thread when a request has been answered.
  std::function<void()> onAnswered;

 private:
  using RequestPtr = std::shared_ptr<Request>;
  void checkId(uint32_t id) const;
  void runNext();
  void startAside(const RequestPtr& request, std::function<nlohmann::json(Request&)> action);
  void run(const RequestPtr& request, const std::function<nlohmann::json(Request&)>& action);
  void answer(const RequestPtr& request, const std::string& text);
  void answerError(const RequestPtr& request, const std::string& message);
  std::shared_ptr<void> stateOf(std::type_index type, const std::function<std::shared_ptr<void>()>& make);

  ServerRank& serverRank_;
  const std::shared_ptr<Outbox> outbox_;
  const Identity identity_;
  const protocol::Limits limits_;

  mutable std::mutex mutex_;
  std::condition_variable answered_;
  bool ended_ = false, running_ = false;
  int aside_ = 0;
  std::map<uint32_t, RequestPtr> requests_;  ///< unanswered requests, by id
  uint64_t requestBytes_ = 0;                ///< sum of their bytes
  std::deque<RequestPtr> queue_;             ///< requests that have not begun
  std::map<std::type_index, std::shared_ptr<void>> states_;
  std::vector<std::shared_ptr<const LoadedModule>> modules_;
  std::vector<int> toldRanks_;  ///< ranks of the last event of tellMissing(), and its requests
  std::set<uint32_t> toldRequests_;
  LedgerEntry incoming_;  ///< memory for the statement that is about to come
  std::string noRoom_;    ///< the reason why there is no memory for it
};

}  // namespace gxy
