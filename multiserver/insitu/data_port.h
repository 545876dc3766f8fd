// SPDX-License-Identifier: Apache-2.0
// Where a rank of the server takes the data of simulations (docs/protocol.md, section 10).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "insitu/plan/records.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy {

/// The server's end of a data connection. Any thread may call all functions; they return at once. It may outlive the port.
class DataLink {
 public:
  virtual ~DataLink() = default;
  virtual void send(protocol::WireMessage message) = 0;
  /// Sends what waits, then the reason, and closes.
  virtual void bye(const std::string& reason) = 0;
};

/// What takes the messages of one data connection. The port's thread calls all functions. They must be short.
class DataTaker {
 public:
  virtual ~DataTaker() = default;
  /// What the simulation may say on this connection.
  virtual protocol::MessageReader::Rules rules() const = 0;
  /// Throws Error for a message that is wrong; the connection is then closed with this as the reason.
  virtual void take(const protocol::WireMessage& message) = 0;
  /// The connection has ended; called once. `regularly`: the simulation has said so.
  virtual void ended(const std::string& reason, bool regularly) = 0;
};

/// Listens while it lives. One thread serves all of its sockets.
class DataPort {
 public:
  /// Returns who takes the messages of a new connection, or null to close it without a word. The port's thread calls it.
  using Admit = std::function<std::shared_ptr<DataTaker>(const insitu::Hello&, std::shared_ptr<DataLink>)>;

  /// Listens on any free port of an address of this machine. Throws Error if it cannot.
  DataPort(const std::string& address, Admit admit);
  /// Closes all connections. Their takers are told.
  ~DataPort();
  DataPort(const DataPort&) = delete;
  DataPort& operator=(const DataPort&) = delete;

  uint16_t port() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gxy
