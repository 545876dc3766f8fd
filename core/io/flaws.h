// SPDX-License-Identifier: Apache-2.0
// Flaws of a file that do not keep it from being shown: its user is told of each kind once, with the place of the first and how
// many there are.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

class Flaws {
 public:
  /// `what` tells what is wrong and what becomes of it: "a face of fewer than 3 corners is left out". `place()`, which is called
  /// for the first of a kind only, tells where: "line 4".
  template <class Place>
  void add(std::string_view what, Place place) {
    for (Kind& kind : kinds_)
      if (kind.what == what) {
        ++kind.count;
        return;
      }
    kinds_.push_back({std::string(what), place(), 1});
  }

  /// "PATH: PLACE: WHAT", and of several "(N of these)", in the order of the first ones.
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
