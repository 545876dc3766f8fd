// SPDX-License-Identifier: Apache-2.0
// The handshake of client and server, and control texts (docs/protocol.md, sections 1, 3 and 8).
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace gxy::protocol {

/// The limits that a server announces to a client.
struct Limits {
  uint64_t requestBytes = uint64_t(16) << 20;
  uint64_t requests = 256;           ///< unanswered requests of a connection
  uint64_t windows = 16;             ///< windows of a connection
  uint64_t pixels = 7680ull * 4320;  ///< pixels of a window
  uint64_t clients = 512;            ///< clients at one time
};

struct Hello {
  std::string token, client;
  std::string tenant = "user";  ///< used only by a server without tokens
  std::string ticket{};         ///< stands for the token, once; empty: there is none
};

struct Welcome {
  std::string server, tenant;
  uint64_t session = 0;
  bool administrator = false;
  bool viewOnly = false;  ///< the client may only use verbs that change nothing
  int ranks = 0;
  Limits limits;
  std::string token{};  ///< for a client that came with a ticket; else empty
};

/// Control texts consist of a word and the text after it.
std::string helloText(const Hello& hello);
std::string welcomeText(const Welcome& welcome);

/// Returns the text after `word ` in a control text; nothing if the text begins otherwise.
std::optional<std::string_view> afterWord(std::string_view text, std::string_view word);

/// Returns text from a client for a log: on one line, and cut if it is long.
std::string asLogged(std::string_view text);

/// These throw Error if the text is not a valid hello or welcome.
Hello parseHello(std::string_view text);
Welcome parseWelcome(std::string_view text);

}  // namespace gxy::protocol
