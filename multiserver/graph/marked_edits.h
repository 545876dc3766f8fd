// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace gxy {

/// By what an edit is known again that is sent a second time, since its reply was lost.
struct EditMark {
  static constexpr size_t kLongest = 100;
  std::string who;      ///< up to kLongest bytes
  uint64_t number = 0;  ///< grows with each edit of theirs
};

/// The last edit of each client that marks its edits, of the 1024 clients that have edited last.
class MarkedEdits {
 public:
  static constexpr size_t kMost = 1024;

  /// The revision of this edit, or of a later one of this client; nothing if there was none.
  std::optional<uint64_t> revisionOf(const EditMark& mark) const {
    const auto last = last_.find(mark.who);
    if (last == last_.end() || last->second.number < mark.number) return {};
    return last->second.revision;
  }

  /// An edit was made. Revisions grow from call to call.
  void add(const EditMark& mark, uint64_t revision) {
    const auto [last, isNew] = last_.try_emplace(mark.who);
    if (!isNew) byRevision_.erase(last->second.revision);
    last->second = {mark.number, revision};
    byRevision_[revision] = mark.who;
    if (last_.size() <= kMost) return;
    last_.erase(byRevision_.begin()->second);
    byRevision_.erase(byRevision_.begin());
  }

 private:
  struct Last {
    uint64_t number = 0, revision = 0;
  };
  std::map<std::string, Last> last_;
  std::map<uint64_t, std::string> byRevision_;
};

}  // namespace gxy
