// SPDX-License-Identifier: Apache-2.0
// Records who uses how much memory, and for what.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gxy {

/// One allocation in a ledger. It is removed from the ledger when the entry is destroyed. Move-only; may
/// outlive the ledger. Only one thread at a time may use an entry.
class LedgerEntry {
 public:
  LedgerEntry() = default;
  LedgerEntry(LedgerEntry&& other) noexcept;
  LedgerEntry& operator=(LedgerEntry&& other) noexcept;
  ~LedgerEntry() { resize(0); }

  int64_t bytes() const { return bytes_; }
  /// Records that the allocation now has this size.
  void resize(int64_t bytes);
  /// Enters another allocation of the same tenant and purpose. It is faster than Ledger::enter(), which
  /// searches the account. If this entry is in no ledger, the new one is in none either. Several threads may
  /// call it at once.
  [[nodiscard]] LedgerEntry another(int64_t bytes) const;

 private:
  friend class Ledger;
  struct State;
  struct Account;
  std::shared_ptr<State> state_;
  Account* account_ = nullptr;  ///< lives as long as the state
  int64_t bytes_ = 0;
};

/// The sizes of all large allocations of a rank, by tenant and purpose ("volume", "geometry", "scene",
/// "framebuffer", "rays"...), in bytes. Thread safe.
class Ledger {
 public:
  Ledger();

  [[nodiscard]] LedgerEntry enter(const std::string& tenant, const std::string& purpose, int64_t bytes);

  int64_t total() const;
  int64_t total(const std::string& tenant) const;
  /// The largest value that total() has had.
  int64_t peak() const;

  struct Line {
    std::string tenant, purpose;
    int64_t bytes;
    bool operator==(const Line&) const = default;
  };
  /// Returns every (tenant, purpose) that uses memory now, in alphabetical order.
  std::vector<Line> snapshot() const;
  /// Returns every (tenant, purpose) that has ever used memory, with its largest size, in alphabetical order.
  std::vector<Line> peaks() const;

 private:
  std::shared_ptr<LedgerEntry::State> state_;
};

/// Enters bytes in a ledger for a purpose ("geometry", "scene"). Throws Error if there is no room for them.
using EnterMemory = std::function<LedgerEntry(const char* purpose, int64_t bytes)>;

/// The memory of this process as the system reports it, for comparison with a ledger: VmRSS and VmHWM of
/// /proc/self/status, in bytes. processBytes() throws Error if they cannot be read.
struct ProcessBytes {
  int64_t resident, peakResident;
};
ProcessBytes processBytes();

}  // namespace gxy
