// SPDX-License-Identifier: Apache-2.0
// Keys: global names of objects, valid on every rank.
#pragma once
#include <atomic>
#include <compare>
#include <cstdint>
#include <functional>

namespace gxy {

/// The global name of an object. The default key names no object. A key is never used twice in the life of a
/// server.
struct Key {
  uint64_t value = 0;

  bool valid() const { return value != 0; }
  auto operator<=>(const Key&) const = default;
};

/// Makes keys that no other rank makes: the upper 24 bits are the rank + 1, the lower 40 bits a counter.
/// Thread safe.
class KeySource {
 public:
  explicit KeySource(int rank) : next_((uint64_t(rank) + 1) << 40) {}
  Key next() { return {next_.fetch_add(1, std::memory_order_relaxed)}; }

 private:
  std::atomic<uint64_t> next_;
};

}  // namespace gxy

template <>
struct std::hash<gxy::Key> {
  size_t operator()(gxy::Key key) const { return std::hash<uint64_t>{}(key.value); }
};
