// SPDX-License-Identifier: Apache-2.0
#include "core/space/ledger.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

struct LedgerEntry::Account {
  int64_t bytes = 0, peak = 0;
};

struct LedgerEntry::State {
  mutable std::mutex mutex;
  std::map<std::pair<std::string, std::string>, Account> accounts;  ///< by (tenant, purpose); never erased
  int64_t total = 0, peak = 0;
};

LedgerEntry::LedgerEntry(LedgerEntry&& other) noexcept
    : state_(std::move(other.state_)),
      account_(std::exchange(other.account_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)) {}

LedgerEntry& LedgerEntry::operator=(LedgerEntry&& other) noexcept {
  if (this != &other) {
    resize(0);
    state_ = std::move(other.state_);
    account_ = std::exchange(other.account_, nullptr);
    bytes_ = std::exchange(other.bytes_, 0);
  }
  return *this;
}

void LedgerEntry::resize(int64_t bytes) {
  if (!account_ || bytes == bytes_) return;
  const std::lock_guard lock(state_->mutex);
  account_->bytes += bytes - bytes_;
  account_->peak = std::max(account_->peak, account_->bytes);
  state_->total += bytes - bytes_;
  state_->peak = std::max(state_->peak, state_->total);
  bytes_ = bytes;
}

LedgerEntry LedgerEntry::another(int64_t bytes) const {
  LedgerEntry entry;
  entry.state_ = state_;
  entry.account_ = account_;
  entry.resize(bytes);
  return entry;
}

Ledger::Ledger() : state_(std::make_shared<LedgerEntry::State>()) {}

LedgerEntry Ledger::enter(const std::string& tenant, const std::string& purpose, int64_t bytes) {
  LedgerEntry entry;
  entry.state_ = state_;
  {
    const std::lock_guard lock(state_->mutex);
    entry.account_ = &state_->accounts[{tenant, purpose}];
  }
  entry.resize(bytes);
  return entry;
}

int64_t Ledger::total() const {
  const std::lock_guard lock(state_->mutex);
  return state_->total;
}

int64_t Ledger::total(const std::string& tenant) const {
  const std::lock_guard lock(state_->mutex);
  int64_t bytes = 0;
  for (const auto& [who, account] : state_->accounts) {
    if (who.first == tenant) bytes += account.bytes;
  }
  return bytes;
}

int64_t Ledger::peak() const {
  const std::lock_guard lock(state_->mutex);
  return state_->peak;
}

std::vector<Ledger::Line> Ledger::snapshot() const {
  const std::lock_guard lock(state_->mutex);
  std::vector<Line> lines;
  for (const auto& [who, account] : state_->accounts) {
    if (account.bytes != 0) lines.push_back({who.first, who.second, account.bytes});
  }
  return lines;
}

std::vector<Ledger::Line> Ledger::peaks() const {
  const std::lock_guard lock(state_->mutex);
  std::vector<Line> lines;
  for (const auto& [who, account] : state_->accounts) {
    if (account.peak != 0) lines.push_back({who.first, who.second, account.peak});
  }
  return lines;
}

ProcessBytes processBytes() {
  std::ifstream status("/proc/self/status");
  ProcessBytes bytes{-1, -1};
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    int64_t kibibytes = 0;
    words >> name >> kibibytes;
    if (name == "VmRSS:") bytes.resident = kibibytes * 1024;
    if (name == "VmHWM:") bytes.peakResident = kibibytes * 1024;
  }
  if (bytes.resident < 0 || bytes.peakResident < 0) {
    throw Error("memory: /proc/self/status has no VmRSS and VmHWM, expected a Linux system with /proc");
  }
  return bytes;
}

}  // namespace gxy
