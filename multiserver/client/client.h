// SPDX-License-Identifier: Apache-2.0
// A client's connection to a multiserver: what msdata, msclient and viewers are built on. docs/protocol.md.
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

/// Help text of programs' option --token-file, which sets Client::Options::tokenFile.
inline constexpr const char* kTokenFileHelp =
    "file with the server's token, - for none (default: where a server on this machine leaves it, if it "
    "does; servers elsewhere need this option, or an ssh tunnel to here)";

/// What a request was answered.
struct Reply {
  bool ok = false;
  std::string error;     ///< where not ok: the message, or why the reply means nothing
  nlohmann::json value;  ///< where ok: the reply's object, or null
};

/// One connection. A thread of its own reads; callbacks run on it, so they must be short and must not wait for replies.
/// When the connection ends, replies that are out become errors. All calls may come from any thread.
class Client {
 public:
  struct Options {
    std::string host = "127.0.0.1";
    uint16_t port = 5001;
    /// Empty: that of the user's run directory (multiserver/protocol/run_files.h), if there is one, for servers on this machine, and
    /// an error for others; "-": no token.
    std::string tokenFile;
    std::string name = "client";
    std::string tenant = "user";        ///< for servers without tokens
    std::chrono::seconds patience{10};  ///< for connecting and the handshake

    // Set before the connection stands, so that nothing is missed.
    std::function<void(const nlohmann::json& event)> onEvent;
    std::function<void(const protocol::PixelHeader&, std::span<const std::byte> data)> onPixels;
    std::function<void(uint32_t request, const nlohmann::json& header, std::span<const std::byte> content)>
        onFile;
    std::function<void(const std::string& reason)> onEnd;  ///< the connection has ended, and why
  };

  /// Connects. Throws Error with what to do where that fails.
  explicit Client(Options options);
  /// Closes; no callback runs afterwards. Not from a callback.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  const protocol::Welcome& welcome() const;

  /// Sends a statement and waits for its reply. Not from a callback.
  Reply request(const std::string& statement);
  /// The same, with an error reply thrown as Error.
  nlohmann::json expect(const std::string& statement);

  using OnReply = std::function<void(const Reply&)>;
  /// Sends a statement; returns its id. `onReply` is called once.
  uint32_t send(const std::string& statement, OnReply onReply);

  bool connected() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gxy
