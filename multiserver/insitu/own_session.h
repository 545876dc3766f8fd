// SPDX-License-Identifier: Apache-2.0
// A session without a client: the server itself runs statements for a tenant.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "multiserver/server/session.h"

namespace gxy {

/// Thread safe. Used on rank 0.
class OwnSession {
 public:
  /// `client` is what logs call it.
  OwnSession(ServerRank& serverRank, const std::string& tenant, const std::string& client);
  ~OwnSession() { end(); }
  OwnSession(const OwnSession&) = delete;
  OwnSession& operator=(const OwnSession&) = delete;

  /// Loads a module on all ranks, unless it is loaded. Waits. Throws Error.
  void load(const std::string& module);
  /// Runs a statement, as a client's, and returns at once. `done` gets an empty text, or the error; any thread calls it, but not
  /// after end().
  void run(const std::string& statement, std::function<void(const std::string& error)> done);
  /// Cancels what is under way, and waits for it. Further statements are ignored. Not within `done`.
  void end();

 private:
  /// Takes the replies from the outbox. It may outlive the session.
  struct Replies {
    std::mutex mutex;
    std::condition_variable ended;
    bool over = false;
    int running = 0;  ///< functions of `waiting` that are being called
    std::map<uint32_t, std::function<void(const std::string&)>> waiting;
    std::weak_ptr<Outbox> outbox;
    void take();
  };

  ServerRank& serverRank_;
  const std::shared_ptr<Replies> replies_ = std::make_shared<Replies>();
  std::shared_ptr<Outbox> outbox_;
  std::shared_ptr<Session> session_;
  uint32_t last_ = 0;  ///< id of a request; guarded by the mutex of the replies
};

}  // namespace gxy
