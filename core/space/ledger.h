// SPDX-License-Identifier: Apache-2.0
// Who uses how much memory, and for what.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace gxy {

/// One allocation in a ledger: entered when made, taken out when destroyed. Move-only; may outlive the
/// ledger. One entry is for one thread at a time.
class LedgerEntry {
 public:
  LedgerEntry() = default;
  LedgerEntry(LedgerEntry&& other) noexcept;
  LedgerEntry& operator=(LedgerEntry&& other) noexcept;
  ~LedgerEntry() { resize(0); }

  int64_t bytes() const { return bytes_; }
  /// The allocation has grown or shrunk to this size.
  void resize(int64_t bytes);
  /// Another allocation of the same tenant and purpose, without the search for its account; of an entry that is in no
  /// ledger, one that is in none either. May be called by several threads at once.
  [[nodiscard]] LedgerEntry another(int64_t bytes) const;

 private:
  friend class Ledger;
  struct State;
  struct Account;
  std::shared_ptr<State> state_;
  Account* account_ = nullptr;  ///< lives as long as the state
  int64_t bytes_ = 0;
};

/// Bytes of all large allocations of a rank, by tenant and purpose ("volume", "geometry", "scene", "framebuffer",
/// "rays"...). Thread safe.
class Ledger {
 public:
  Ledger();

  [[nodiscard]] LedgerEntry enter(const std::string& tenant, const std::string& purpose, int64_t bytes);

  int64_t total() const;
  int64_t total(const std::string& tenant) const;
  /// The largest that total() has been.
  int64_t peak() const;

  struct Line {
    std::string tenant, purpose;
    int64_t bytes;
    bool operator==(const Line&) const = default;
  };
  /// Every (tenant, purpose) that uses memory now, in alphabetical order.
  std::vector<Line> snapshot() const;
  /// Every (tenant, purpose) that has ever used memory, with the most that it has been.
  std::vector<Line> peaks() const;

 private:
  std::shared_ptr<LedgerEntry::State> state_;
};

/// What the system says that this process uses, to compare a ledger with: VmRSS and VmHWM of
/// /proc/self/status. Throws Error where that cannot be read.
struct ProcessBytes {
  int64_t resident, peakResident;
};
ProcessBytes processBytes();

}  // namespace gxy
