// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/hosts.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace gxy {

namespace {

std::string lowered(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return lower;
}

// Returns an address in its usual form, or a name in lower case; empty if the text is neither.
std::string usualForm(std::string_view text) {
  std::string host = lowered(text);
  std::array<unsigned char, 16> bytes{};
  std::array<char, INET6_ADDRSTRLEN> form{};
  for (const int family : {AF_INET, AF_INET6})
    if (inet_pton(family, host.c_str(), bytes.data()) == 1)
      return inet_ntop(family, bytes.data(), form.data(), form.size());
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz0123456789-._";
  return host.find_first_not_of(kLetters) == host.npos ? host : std::string();
}

// Returns the host of `HOST[:PORT]` in its usual form, IPv6 addresses without brackets; empty if the text is
// of another form.
std::string hostPartOf(std::string_view text) {
  std::string_view host = text, port;
  if (text.starts_with('[')) {
    const size_t end = text.find(']');
    if (end == text.npos) return {};
    host = text.substr(1, end - 1);
    port = text.substr(end + 1);
    if (host.find(':') == host.npos) return {};
  } else if (const size_t colon = text.find(':'); colon != text.npos) {
    host = text.substr(0, colon);
    port = text.substr(colon);
  }
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!port.empty() && (port.size() < 2 || port.size() > 6 || port[0] != ':' ||
                        !std::all_of(port.begin() + 1, port.end(), digit)))
    return {};
  return usualForm(host);
}

bool isLoopback(const std::string& host) {
  in_addr address{};
  if (inet_pton(AF_INET, host.c_str(), &address) == 1) return ntohl(address.s_addr) >> 24 == 127;
  return host == "::1";
}

}  // namespace

Hosts::Hosts(const std::vector<std::string>& names, const std::string& bind) : bind_(usualForm(bind)) {
  for (const std::string& name : names) names_.push_back(usualForm(name));
  if (bind_ == "0.0.0.0" || bind_ == "::") bind_.clear();
}

std::string Hosts::wrongName(const std::string& name) {
  if (!usualForm(name).empty()) return {};
  return "expected a host's name or address without a port, as in a browser's address bar, found '" + name +
         "'";
}

bool Hosts::allows(std::string_view host) const {
  const std::string name = hostPartOf(host);
  if (name.empty()) return false;
  return name == "localhost" || isLoopback(name) || name == bind_ ||
         std::find(names_.begin(), names_.end(), name) != names_.end();
}

bool Hosts::allowsOrigin(std::string_view origin, std::string_view host) const {
  if (!allows(host)) return false;
  const std::string page = lowered(origin), server = lowered(host);
  if (page == "http://" + server) return true;
  return page == "https://" + server &&
         std::find(names_.begin(), names_.end(), hostPartOf(host)) != names_.end();
}

}  // namespace gxy
