// SPDX-License-Identifier: Apache-2.0
// Rank 0's ear: accepts clients, gives each a session, and ends.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "multiserver/server/connection.h"
#include "multiserver/server/node.h"

namespace gxy {

struct ServerOptions {
  std::string bind = "127.0.0.1";
  uint16_t port = 5001;              ///< 0: any that is free
  std::chrono::seconds idleExit{0};  ///< stops after so long without clients; 0: never
  size_t tenantClients = 256;        ///< of those that may be connected, of one tenant
  bool signals = true;               ///< SIGINT, SIGTERM and SIGUSR2 stop it
  Connection::Options connection;
};

/// Listens while it lives. One thread serves all sockets; requests run on the Transport's threads.
class Server {
 public:
  /// Throws Error where it cannot listen. `onStop` is called once, from any thread, when the server is to end: by quit, a
  /// signal or idleness. It must be short.
  Server(Node& node, ServerOptions options, std::function<void()> onStop);
  /// Says bye to all clients, and waits for their requests.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  /// Connected, or gone with requests that still come to their end.
  size_t clients() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gxy
