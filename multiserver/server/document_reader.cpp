// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/document_reader.h"

#include <malloc.h>

#include <algorithm>

#include "core/scene/json_text.h"
#include "multiserver/protocol/json.h"
#include "multiserver/server/session.h"

namespace gxy {

namespace {

constexpr size_t kShort = 4096;          // Shorter texts are always read: they may free memory.
constexpr size_t kLong = 64 << 10;       // Longer texts wait for their turn.
constexpr int64_t kGivenBack = 8 << 20;  // From this much on, memory is returned to the system at once.
constexpr int64_t kBytesOfAValue = 128;  // a value, its place in a growing list, and its object
constexpr int64_t kBytesOfACharacter = 2;

}  // namespace

// Each value follows a comma or an opening bracket.
int64_t parsingBytes(std::string_view text) {
  const auto values =
      1 + std::count_if(text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == '{'; });
  return std::min(int64_t(values), int64_t(kMaxJsonValues)) * kBytesOfAValue +
         int64_t(text.size()) * kBytesOfACharacter;
}

std::shared_ptr<void> ReadingTurns::take(Request& request) {
  const std::string tenant = request.session().tenant();
  request.onCancel([this] {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return request.cancelled() || reading_.count(tenant) == 0; });
  request.check();
  reading_.insert(tenant);
  return {nullptr, [this, tenant](void*) {
            const std::lock_guard again(mutex_);
            reading_.erase(tenant);
            changed_.notify_all();
          }};
}

DocumentReader::~DocumentReader() {
  if (bytes_ >= kGivenBack) ::malloc_trim(0);
}

void DocumentReader::makeRoom(std::string_view text) {
  request_.check();
  if (text.size() <= kShort) return;
  const Session& session = request_.session();
  const bool hasTurn = turn_.use_count() > 0;  // The pointer is null even when it holds a turn.
  if (text.size() > kLong && !hasTurn) turn_ = session.serverRank().reading.take(request_);
  const int64_t bytes = parsingBytes(text);
  memory_.push_back(session.serverRank().takeMemory(session.tenant(), "documents", bytes));
  bytes_ += bytes;
}

StateFile DocumentReader::state(std::string_view text, const std::string& what) {
  makeRoom(text);
  const NamedFileReader readFile = [this](const std::string& name) {
    std::string content = request_.session().serverRank().folders.textOf(name, int64_t(kMaxJsonBytes));
    makeRoom(content);
    return content;
  };
  return readState(text, what, readFile, &request_.session().serverRank().filters);
}

StateFile DocumentReader::datasets(std::string_view text, const std::string& what) {
  makeRoom(text);
  return readDatasetEntries(text, what, &request_.session().serverRank().filters);
}

nlohmann::json DocumentReader::object(std::string_view text, const std::string& what) {
  makeRoom(text);
  return protocol::parseObject(text, what);
}

}  // namespace gxy
