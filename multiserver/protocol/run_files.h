// SPDX-License-Identifier: Apache-2.0
// The user's run directory, where a server leaves its tokens for local clients (docs/protocol.md, section 1).
#pragma once
#include <cstdint>
#include <string>
#include <utility>

namespace gxy::protocol {

/// Returns the path of the run directory, which need not exist.
std::string runDirectory();

/// Makes the run directory, accessible to its user only. Throws Error if it belongs to another user or is
/// accessible to others.
void makeRunDirectory();

/// Returns the path of the token file of a server on this port: that of a tenant, or, without one, the
/// administrator's.
std::string tokenFile(uint16_t port, const std::string& tenant = {});

/// Returns the token in a file. Throws Error, with advice, if there is none.
std::string readToken(const std::string& path);

/// Returns the token that a server on this port has left in the run directory. Throws Error if there is none,
/// or if the server that left it was killed: a server keeps its token file locked while it runs. On file
/// systems without locks, every token counts as valid.
std::string readServerToken(uint16_t port);

/// Removes a token file if the server that left it was killed. Does nothing if the file is in use or is
/// not a token file.
void removeStaleToken(const std::string& path);
/// The same for all token files of the run directory, which need not exist.
void removeStaleTokens();

/// A token file that exists while this object lives, with mode 0600 from the start. It is locked, so that no
/// other process writes a token file there.
class TokenFile {
 public:
  /// Throws Error if the file cannot be written, or a running server has its token there.
  TokenFile(std::string path, const std::string& token);
  ~TokenFile();
  TokenFile(TokenFile&& other) noexcept
      : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}
  TokenFile& operator=(TokenFile&&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_ = -1;  ///< descriptor, locked
};

}  // namespace gxy::protocol
