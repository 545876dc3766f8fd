// SPDX-License-Identifier: Apache-2.0
// Under which names browsers may reach the server, and which pages may open a WebSocket to it.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

/// Rules against web pages of others. A page whose name was made to lead to this machine (DNS rebinding) comes
/// with its own name as Host. A page from elsewhere that opens a WebSocket comes with its own Origin.
/// Thread safe.
class Hosts {
 public:
  /// `names` are those of --host, for instance of a reverse proxy; `bind` the address that the server listens
  /// on. localhost and loopback addresses are always allowed, an unspecified address (0.0.0.0, ::) never is.
  Hosts(const std::vector<std::string>& names, const std::string& bind);

  /// Returns what is wrong with a name for --host; empty if nothing is.
  static std::string wrongName(const std::string& name);

  /// Whether the server answers for the value of a field Host, with any port, as tunnels map ports.
  bool allows(std::string_view host) const;
  /// Whether a page from `origin` may open a WebSocket at `host`: both have the same host and port. The scheme is
  /// http, or, under the names of --host, where a proxy may speak TLS, https.
  bool allowsOrigin(std::string_view origin, std::string_view host) const;

 private:
  std::vector<std::string> names_;  ///< in the form that hostOf() returns
  std::string bind_;
};

}  // namespace gxy
