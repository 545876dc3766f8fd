// SPDX-License-Identifier: Apache-2.0
// Stands before libgalaxy_insitu, whose functions the test program defines, too: keeps what the adaptor says and the library takes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "insitu/api/galaxy_insitu.h"

struct gxy_sim {
  struct Grid {
    int of;
    std::array<int64_t, 3> size, first, count;
    std::array<double, 3> origin, spacing;
    bool operator==(const Grid&) const = default;
  };
  struct Points {
    gxy_array positions, ids;
    std::vector<double> box, at{}, numbers{};  ///< the last two are what gxy_publish() has read
    gxy_array connectivity{}, types{}, offsets{};
    int64_t cells = 0, pointsOfEach = 0;               ///< of cells; 0 where there are offsets
    std::vector<double> corners{}, kinds{}, begins{};  ///< what gxy_publish() has read
  };
  gxy_sim* checks = nullptr;  ///< a real one, connected to nothing, which says what is wrong
  std::string name, options, message;
  int rank = 0, ranks = 0;
  std::map<std::pair<std::string, int>, Grid> grids;                      // by mesh and block
  std::map<std::tuple<std::string, int, std::string>, gxy_array> fields;  // and name
  /// What gxy_publish() has read of each field, as doubles: x fastest, components together.
  std::map<std::tuple<std::string, int, std::string>, std::vector<double>> read;
  std::map<std::string, Points> points;                  ///< also those of cells
  std::map<std::string, std::set<std::string>> ofCells;  ///< fields of cells, by mesh
  std::vector<std::pair<int64_t, double>> steps;
  std::vector<std::pair<int64_t, double>> skipped;
  int published = GXY_TAKEN;  ///< what gxy_publish() returns; or GXY_LOST
  bool last = false;
  double closed = -1;
};

namespace gxy::test {
gxy_sim& recorded();  ///< the newest stream
}
