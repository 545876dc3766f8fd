// SPDX-License-Identifier: Apache-2.0
// The user's run directory, where a server leaves its tokens for local clients. docs/protocol.md section 1.
#pragma once
#include <cstdint>
#include <string>

namespace gxy::protocol {

/// The name of the run directory; it need not exist.
std::string runDirectory();

/// Makes it, for its user only. Throws Error if it is another's or open to others.
void makeRunDirectory();

/// The file of the token of a server on this port, for a tenant; without one, the administrator's.
std::string tokenFile(uint16_t port, const std::string& tenant = {});

/// The token in a file. Throws Error, with what to do, where there is none.
std::string readToken(const std::string& path);

/// Writes a token, mode 0600 from the start.
void writeToken(const std::string& path, const std::string& token);

}  // namespace gxy::protocol
