// SPDX-License-Identifier: Apache-2.0
// The listening server on rank 0: accepts clients, gives each a session, and decides when to stop.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "multiserver/server/connection.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

struct ServerOptions {
  std::string bind = "127.0.0.1";
  uint16_t port = 5001;              ///< 0: any free port
  std::chrono::seconds idleExit{0};  ///< time without clients after which the server stops; 0: never
  size_t tenantClients = 256;        ///< number of connected clients of one tenant
  bool signals = true;               ///< SIGINT, SIGTERM and SIGUSR2 stop it
  bool gui = true;                   ///< browsers are served; otherwise they are disconnected
  std::string guiFolder;             ///< the files of the GUI; empty: a page that says how to get it
  std::vector<std::string> hosts;    ///< further names under which browsers reach the server
  Connection::Options connection;
};

/// Listens while it lives. One thread serves all sockets; requests run on the Transport's threads.
class Server {
 public:
  /// Throws Error if it cannot listen, or the GUI's files cannot be read. `onStop` is called once, from any thread, when the server should end:
  /// after quit, a signal, idleness, or the death of a rank. It must be short.
  Server(ServerRank& serverRank, ServerOptions options, std::function<void()> onStop);
  /// Says bye to all clients, and waits for their requests to end.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  /// The number of clients that are connected, or have gone but have requests that have not ended.
  size_t clients() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gxy
