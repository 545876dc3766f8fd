// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/tickets.h"

#include <algorithm>
#include <cstdint>

#include "multiserver/server/tenants.h"

namespace gxy {

namespace {

std::string newTicket() {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  std::string text;
  uint32_t bits = 0;
  int count = 0;
  for (const unsigned char byte : randomBytes()) {
    bits = bits << 8 | byte;
    for (count += 8; count >= 6; count -= 6) text += kDigits[bits >> (count - 6) & 63];
  }
  return text + kDigits[bits << (6 - count) & 63];
}

}  // namespace

void Tickets::forget(Clock::time_point now) {
  std::erase_if(entries_, [now](const Entry& entry) { return entry.end <= now; });
}

std::string Tickets::issue(const std::string& token, std::chrono::seconds lifetime, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  forget(now);
  const auto isOf = [&](const Entry& entry) { return entry.token == token; };
  if (size_t(std::count_if(entries_.begin(), entries_.end(), isOf)) >= kMost)
    entries_.erase(std::find_if(entries_.begin(), entries_.end(), isOf));
  return entries_.emplace_back(Entry{newTicket(), token, now + lifetime}).ticket;
}

std::optional<std::string> Tickets::redeem(const std::string& ticket, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  forget(now);
  auto found = entries_.end();
  for (auto at = entries_.begin(); at != entries_.end(); ++at)  // compare all, in constant time
    if (sameToken(ticket, at->ticket)) found = at;
  if (found == entries_.end()) return std::nullopt;
  std::string token = std::move(found->token);
  entries_.erase(found);
  return token;
}

}  // namespace gxy
