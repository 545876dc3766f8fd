// SPDX-License-Identifier: Apache-2.0
// The user's run directory, where a server leaves its tokens for local clients. docs/protocol.md section 1.
#pragma once
#include <cstdint>
#include <string>
#include <utility>

namespace gxy::protocol {

/// The name of the run directory; it need not exist.
std::string runDirectory();

/// Makes it, for its user only. Throws Error if it is another's or open to others.
void makeRunDirectory();

/// The file of the token of a server on this port, for a tenant; without one, the administrator's.
std::string tokenFile(uint16_t port, const std::string& tenant = {});

/// The token in a file. Throws Error, with what to do, where there is none.
std::string readToken(const std::string& path);

/// The token that a server on this port has left here. Throws Error where there is none, or where the server that left it was
/// killed: a server keeps its token's file locked while it runs. Where files cannot be locked, any token is taken as valid.
std::string readServerToken(uint16_t port);

/// Removes a token's file if the server that left it was killed. Does nothing where it is in use, or is no token.
void removeStaleToken(const std::string& path);
/// The same for all token files of the run directory, which need not exist.
void removeStaleTokens();

/// A file with a token, mode 0600 from the start, while it lives. Another process that would write one there is refused.
class TokenFile {
 public:
  /// Throws Error where it cannot be written, or a server that runs has its own there.
  TokenFile(std::string path, const std::string& token);
  ~TokenFile();
  TokenFile(TokenFile&& other) noexcept
      : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}
  TokenFile& operator=(TokenFile&&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_ = -1;  ///< locked
};

}  // namespace gxy::protocol
