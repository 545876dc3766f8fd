// SPDX-License-Identifier: Apache-2.0
// Collects flaws of a file that do not prevent showing it. The user gets one warning for each kind, with the
// place of the first flaw and the number of flaws.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

class Flaws {
 public:
  /// Adds a flaw. `what` is its kind; it says what is wrong and what is done about it: "a face of fewer
  /// than 3 corners is left out". `place()` returns where it is: "line 4". It is called only for the
  /// first flaw of a kind.
  template <class Place>
  void add(std::string_view what, Place place) {
    for (Kind& kind : kinds_)
      if (kind.what == what) {
        ++kind.count;
        return;
      }
    kinds_.push_back({std::string(what), place(), 1});
  }

  /// Returns "PATH: PLACE: WHAT" for each kind, with "(N of these)" if there are several, in the order of
  /// first flaws.
  std::vector<std::string> warnings(const std::string& path) const {
    std::vector<std::string> all;
    for (const Kind& kind : kinds_)
      all.push_back(path + ": " + (kind.place.empty() ? "" : kind.place + ": ") + kind.what +
                    (kind.count > 1 ? " (" + std::to_string(kind.count) + " of these)" : ""));
    return all;
  }

 private:
  struct Kind {
    std::string what, place;
    uint64_t count;
  };
  std::vector<Kind> kinds_;
};

}  // namespace gxy
