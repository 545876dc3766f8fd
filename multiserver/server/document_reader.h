// SPDX-License-Identifier: Apache-2.0
// JSON that requests hold, and the files that it names, read within bounds. Rank 0.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/state_file.h"
#include "core/space/ledger.h"

namespace gxy {

class Request;

/// Whose long documents are being read. Thread safe.
class ReadingTurns {
 public:
  /// The turn of the request's tenant, until let go; waits for it. Throws Error when the request is cancelled. The turns
  /// outlive it and the request.
  [[nodiscard]] std::shared_ptr<void> take(Request& request);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> reading_;  ///< tenants
};

/// Reads what a request says, on one thread. A text takes many times its bytes while it is parsed: that is its tenant's
/// memory as long as this lives, which therefore should end before the request's work begins; of long texts a tenant
/// reads one at a time. All throw Error: for what is wrong with a text, where there is no memory for it, when cancelled.
class DocumentReader {
 public:
  explicit DocumentReader(Request& request) : request_(request) {}
  ~DocumentReader();
  DocumentReader(const DocumentReader&) = delete;
  DocumentReader& operator=(const DocumentReader&) = delete;

  /// readState(); preset and camera files are such as clients may read (DataFolders::toRead).
  StateFile state(std::string_view text, const std::string& what);
  /// protocol::parseObject().
  nlohmann::json object(std::string_view text, const std::string& what);

 private:
  void makeRoom(std::string_view text);

  Request& request_;
  std::shared_ptr<void> turn_;
  std::vector<LedgerEntry> memory_;
  int64_t bytes_ = 0;  ///< of memory_
};

}  // namespace gxy
