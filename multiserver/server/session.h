// SPDX-License-Identifier: Apache-2.0
// One client's requests: run in their order, beside all others'. Rank 0. No sockets here.
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
#include "multiserver/server/node.h"
#include "multiserver/server/outbox.h"

namespace gxy {

class LoadedModule;
class Session;

/// A statement that a client has sent and that is not answered yet. Thread safe.
class Request {
 public:
  Request(Session& session, uint32_t id, Bytes text);

  Session& session() const { return session_; }
  uint32_t id() const { return id_; }
  const std::string& verb() const { return verb_; }
  const std::string& arguments() const { return arguments_; }
  size_t bytes() const { return bytes_; }

  bool cancelled() const { return cancelled_; }
  /// Throws Error "cancelled" if so. Long work calls it often.
  void check() const;
  /// Calls `action` (short, from any thread) when the request is cancelled, at once if it is.
  void onCancel(std::function<void()> action);
  void cancel();
  /// Calls `action` (short) once the reply has been given to the outbox.
  void onAnswered(std::function<void()> action);

  /// A progress event, at most ten a second, the last one and those with which a phase begins always.
  void progress(int64_t done, int64_t of, const std::string& text, bool phase = false);

 private:
  /// Takes verb and arguments out of the text, if that has not been done. Before anyone else has the request. Throws Error.
  void read();

  Session& session_;
  const uint32_t id_;
  const size_t bytes_;
  Bytes text_;  ///< not read yet
  std::string verb_, arguments_;
  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;
  friend class Session;
  LedgerEntry memory_;
  std::vector<std::function<void()>> cancelActions_, answeredActions_;
  std::chrono::steady_clock::time_point lastProgress_{};
};

/// What becomes of the statements of one connection. Requests run on threads of their own (Transport::postWaiting): those
/// in turn one after the other, those aside beside them, of which at most kAside run at once. Nothing here waits for
/// another session.
class Session : public std::enable_shared_from_this<Session> {
 public:
  struct Identity {
    uint64_t number = 0;
    std::string client, tenant;
    bool administrator = false;
  };

  static constexpr int kAside = 8;  ///< requests that run at once beside those in turn; each holds a thread

  /// The outbox is the connection's and outlives the session's requests.
  Session(Node& node, std::shared_ptr<Outbox> outbox, Identity identity, protocol::Limits limits);
  ~Session();

  Node& node() const { return node_; }
  Outbox& outbox() const { return *outbox_; }
  const std::shared_ptr<Outbox>& sharedOutbox() const { return outbox_; }
  const Identity& identity() const { return identity_; }
  const std::string& tenant() const { return identity_.tenant; }
  const protocol::Limits& limits() const { return limits_; }

  /// Takes the memory of a statement of so many bytes that is about to come; short ones may always. False where there is
  /// none: it is not to be kept, but refused. This and the next two: one thread at a time.
  bool makeRoom(uint64_t bytes);
  /// Takes a statement; its reply will come to the outbox. Throws Error for an id that is in use: the client does not keep
  /// to the protocol.
  void submit(uint32_t id, Bytes text);
  /// Answers the statement for which there was no room with an error. Throws as submit() does.
  void refuse(uint32_t id);
  size_t unanswered() const;
  /// So many statements are not answered yet, or so many bytes of them (more than twice those of the longest), that no more
  /// should be read.
  bool full() const;

  /// Cancels a request, if there is one with this id; one that has not begun is answered at once.
  void cancel(uint32_t id);

  /// Tells the client, by an event, which ranks do not answer and which of its requests wait meanwhile: again when either has
  /// changed, and once when all ranks answer again.
  void tellMissing(const std::vector<Presence::Missing>& missing);

  /// Cancels all and drops what modules keep; requests that run end soon, their replies going nowhere. Later statements are
  /// not taken. May be called more than once; waits for requests, so not from a handler.
  void end();

  /// What a module keeps for this session: the T that was made first. Gone when the session has ended.
  template <class T>
  std::shared_ptr<T> state(const std::function<std::shared_ptr<T>()>& make) {
    return std::static_pointer_cast<T>(stateOf(typeid(T), [&]() -> std::shared_ptr<void> { return make(); }));
  }
  /// The T, or null.
  template <class T>
  std::shared_ptr<T> stateIfAny() {
    return std::static_pointer_cast<T>(stateOf(typeid(T), nullptr));
  }

  /// The modules of this session, in the order of their loading.
  std::vector<std::shared_ptr<const LoadedModule>> modules() const;
  void addModule(std::shared_ptr<const LoadedModule> module);

  /// Called, from any thread, when a request has been answered.
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

  Node& node_;
  const std::shared_ptr<Outbox> outbox_;
  const Identity identity_;
  const protocol::Limits limits_;

  mutable std::mutex mutex_;
  std::condition_variable answered_;
  bool ended_ = false, running_ = false;
  int aside_ = 0;
  std::map<uint32_t, RequestPtr> requests_;  ///< not answered
  uint64_t requestBytes_ = 0;                ///< theirs
  std::deque<RequestPtr> queue_;             ///< not begun
  std::map<std::type_index, std::shared_ptr<void>> states_;
  std::vector<std::shared_ptr<const LoadedModule>> modules_;
  std::vector<int> toldRanks_;  ///< by tellMissing()
  std::set<uint32_t> toldRequests_;
  LedgerEntry incoming_;  ///< for the statement that comes
  std::string noRoom_;    ///< why there is none for it
};

}  // namespace gxy
