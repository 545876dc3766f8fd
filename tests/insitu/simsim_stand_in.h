// SPDX-License-Identifier: Apache-2.0
// Stands in for the library of the in situ interface: keeps what the ranks of a simulation say.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"

/// One rank's side. What gxy_publish() reads through the strides of a field is in `read`, x fastest.
struct gxy_sim {
  std::string name, options, message = "nothing was wrong";
  int rank = 0, ranks = 0;
  std::array<int64_t, 3> size{}, first{}, count{};
  std::array<double, 3> origin{}, spacing{};
  std::map<std::string, gxy_array> fields;

  struct Step {
    int64_t step;
    double time;
    std::map<std::string, std::vector<std::byte>> read;
  };
  std::vector<Step> steps;
  double closed = -1;  ///< seconds given to gxy_close()
};

namespace gxy::test {

/// What the functions of the interface return, and all sides that were opened, by rank.
struct StandIn {
  int gridResult = GXY_TAKEN, publishResult = GXY_TAKEN;
  std::map<int, gxy_sim> sides;
};
StandIn& standIn();

}  // namespace gxy::test
