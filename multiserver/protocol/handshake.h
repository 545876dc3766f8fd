// SPDX-License-Identifier: Apache-2.0
// What client and server tell each other first. docs/protocol.md sections 1, 3 and 8.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace gxy::protocol {

struct Limits {
  uint64_t requestBytes = uint64_t(16) << 20;
  uint64_t requests = 256;           ///< not yet answered, of a connection
  uint64_t windows = 16;             ///< of a connection
  uint64_t pixels = 7680ull * 4320;  ///< of a window
  uint64_t clients = 512;            ///< at once
};

struct Hello {
  std::string token, client;
  std::string tenant = "user";  ///< only read by a server without tokens
};

struct Welcome {
  std::string server, tenant;
  uint64_t session = 0;
  bool administrator = false;
  int ranks = 0;
  Limits limits;
};

/// Control texts: a word, then what follows it.
std::string helloText(const Hello& hello);
std::string welcomeText(const Welcome& welcome);

/// What follows `word ` in a control text; nothing where it begins otherwise.
std::optional<std::string_view> afterWord(std::string_view text, std::string_view word);

/// Text from a client for a log: one line, cut when long.
std::string asLogged(std::string_view text);

/// These throw Error where the text is another.
Hello parseHello(std::string_view text);
Welcome parseWelcome(std::string_view text);

}  // namespace gxy::protocol
