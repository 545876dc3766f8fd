// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/place.h"

#include <charconv>
#include <string>
#include <string_view>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy::simsim {
namespace {

struct Names {
  const char *rank, *ranks;
};
// Those of MPI libraries first: mpirun inside an allocation of Slurm leaves Slurm's variables as they were.
// SLURM_NTASKS is not used, because it is also set where srun has started nothing, in a batch script.
constexpr Names kLaunchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                {"PMI_RANK", "PMI_SIZE"},
                                {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};

int numberIn(const char* name, std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0)
    throw Error("environment variable " + std::string(name) + ": expected a whole number from 0 up, found " +
                inQuotes(text));
  return number;
}

}  // namespace

Place placeFrom(const std::function<const char*(const char* name)>& variable) {
  for (const Names& names : kLaunchers) {
    const char *rank = variable(names.rank), *ranks = variable(names.ranks);
    if (!rank || !ranks) continue;
    const Place place{numberIn(names.rank, rank), numberIn(names.ranks, ranks)};
    if (place.rank >= place.ranks)
      throw Error("environment variables " + std::string(names.rank) + " and " + names.ranks +
                  ": expected a rank below the number of ranks, found " + rank + " and " + ranks);
    return place;
  }
  return {};
}

}  // namespace gxy::simsim
