// SPDX-License-Identifier: Apache-2.0
// Reads the JSON of requests and the files that it names, within bounds on memory. Used on rank 0.
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

/// Returns an upper bound on the memory, in bytes, that parsing this JSON takes.
int64_t parsingBytes(std::string_view text);

/// Lets each tenant read one long document at a time. Thread safe.
class ReadingTurns {
 public:
  /// Waits for the turn of the request's tenant. The turn ends when the result is released. Throws Error if
  /// the request is cancelled. This object must outlive the result and the request.
  [[nodiscard]] std::shared_ptr<void> take(Request& request);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> reading_;  ///< tenants
};

/// Reads the documents of one request, on one thread. Parsing a text takes many times its size. This memory
/// is charged to the tenant as long as the reader lives, so the reader should be destroyed before the
/// request's work begins. A tenant reads one text over 64 KiB at a time. All functions throw Error if a text
/// is malformed, if there is no memory for it, or if the request is cancelled.
class DocumentReader {
 public:
  explicit DocumentReader(Request& request) : request_(request) {}
  ~DocumentReader();
  DocumentReader(const DocumentReader&) = delete;
  DocumentReader& operator=(const DocumentReader&) = delete;

  /// Calls readState(). Preset and camera files must be files that clients may read (DataFolders::toRead()).
  StateFile state(std::string_view text, const std::string& what);
  /// Calls readDatasetEntries().
  StateFile datasets(std::string_view text, const std::string& what);
  /// Calls protocol::parseObject().
  nlohmann::json object(std::string_view text, const std::string& what);

 private:
  void makeRoom(std::string_view text);

  Request& request_;
  std::shared_ptr<void> turn_;
  std::vector<LedgerEntry> memory_;
  int64_t bytes_ = 0;  ///< sum of memory_
};

}  // namespace gxy
