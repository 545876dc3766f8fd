// SPDX-License-Identifier: Apache-2.0
// A client's connection to a multiserver (docs/protocol.md). msdata, msclient and viewers use it.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/pixel_record.h"

namespace gxy {

/// Help text for the option --token-file of programs, which sets Client::Options::tokenFile.
inline constexpr const char* kTokenFileHelp =
    "file with the server's token, - for none (default: where a server on this machine leaves it, if it "
    "does; servers elsewhere need this option, or an ssh tunnel to here)";

/// The reply to a request.
struct Reply {
  bool ok = false;
  std::string error;     ///< if not ok: the message, or why the reply cannot be understood
  nlohmann::json value;  ///< if ok: the reply's object, or null
};

/// One connection. It has a thread that reads and runs all callbacks, so callbacks must be short and must not
/// wait for replies. When the connection ends, outstanding requests get an error as their reply. Any thread
/// may call all functions.
class Client {
 public:
  struct Options {
    std::string host = "127.0.0.1";
    uint16_t port = 5001;
    /// Path of a file with the server's token. "-": no token. Empty: for a server on this machine, the
    /// token in the user's run directory (multiserver/protocol/run_files.h), if there is one; for other
    /// servers, an error.
    std::string tokenFile;
    std::string name = "client";
    std::string tenant = "user";        ///< used by servers without tokens
    std::chrono::seconds patience{10};  ///< time for connecting and the handshake together

    // Callbacks are options, so that they are set before anything can arrive.
    std::function<void(const nlohmann::json& event)> onEvent;
    std::function<void(const protocol::PixelHeader&, std::span<const std::byte> data)> onPixels;
    std::function<void(uint32_t request, const nlohmann::json& header, std::span<const std::byte> content)>
        onFile;
    std::function<void(const std::string& reason)> onEnd;  ///< called when the connection has ended
  };

  /// Connects. Throws Error, with advice, if that fails.
  explicit Client(Options options);
  /// Closes the connection. No callback runs afterwards. Must not be called from a callback.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  const protocol::Welcome& welcome() const;

  /// Sends a statement and waits for its reply. Must not be called from a callback. Throws Error if the
  /// connection has ended.
  Reply request(const std::string& statement);
  /// The same, but throws an error reply as Error, and returns the reply's object.
  nlohmann::json expect(const std::string& statement);

  using OnReply = std::function<void(const Reply&)>;
  /// Sends a statement and returns its id. `onReply` is called once. Throws Error if the connection has ended.
  uint32_t send(const std::string& statement, OnReply onReply);

  bool connected() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gxy
