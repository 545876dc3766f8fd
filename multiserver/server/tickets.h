// SPDX-License-Identifier: Apache-2.0
// Tickets: what stands in a URL in place of a token, as URLs are kept and shown in many places.
#pragma once
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace gxy {

/// Issues tickets for tokens. Each can be redeemed once, and only for a while. Thread safe.
class Tickets {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds kShort{60};  ///< for one that a program opens at once
  static constexpr std::chrono::seconds kLong{600};  ///< for one that a person copies from a terminal
  static constexpr size_t kMost = 64;  ///< of a token that are not redeemed; then the oldest goes

  /// Returns a new ticket: 43 characters of base64url from 32 random bytes.
  std::string issue(const std::string& token, std::chrono::seconds lifetime,
                    Clock::time_point now = Clock::now());
  /// Returns the token of a ticket, which is of no use afterwards; nothing if there is none, or it is too old.
  std::optional<std::string> redeem(const std::string& ticket, Clock::time_point now = Clock::now());

 private:
  struct Entry {
    std::string ticket, token;
    Clock::time_point end;
  };
  void forget(Clock::time_point now);

  std::mutex mutex_;
  std::deque<Entry> entries_;  ///< in the order in which they were issued
};

}  // namespace gxy
