// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <thread>
#include <vector>

#include "core/comm/error.h"
#include "insitu/api/galaxy_insitu.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

void simulate(const To& to, const SimulatedRank& what) {
  nlohmann::json options = to.options();
  options.update({{"policy", "wait"}, {"time-out", nullptr}});
  const std::unique_ptr<gxy_sim, void (*)(gxy_sim*)> sim(
      gxy_open("bench", what.rank, what.ranks, options.dump().c_str()), [](gxy_sim* s) { gxy_close(s, 5); });
  // A slab of all x and y.
  const int64_t side = what.side, low = side * what.rank / what.ranks,
                high = side * (what.rank + 1) / what.ranks;
  const int64_t size[3] = {side, side, side}, first[3] = {0, 0, low}, count[3] = {side, side, high - low};
  const double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
  std::vector<float> values(size_t(side * side * (high - low)));
  for (size_t i = 0; i < values.size(); i++) values[i] = float(i % 1000);
  gxy_grid(sim.get(), "grid", 0, GXY_OF_POINTS, size, first, count, origin, spacing);
  gxy_field(sim.get(), "grid", 0, "f", GXY_OF_POINTS,
            {values.data(), GXY_FLOAT32, 1, {4, 4 * side, 4 * side * side}, 0, 0});

  gxy_stat statistics{};
  const auto awaitPublished = [&](int64_t steps) {
    for (const double begin = now(); statistics.published < steps; gxy_statistics(sim.get(), &statistics)) {
      if (now() > begin + 60) throw Error("a step is not published: " + std::string(gxy_message(sim.get())));
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  };
  int64_t step = 0;
  const auto publish = [&] {
    step++;
    if (gxy_publish(sim.get(), step, double(step)) != GXY_TAKEN)
      throw Error("a step is not taken: " + std::string(gxy_message(sim.get())));
  };
  while (step < what.warm) publish();
  awaitPublished(what.warm);

  std::string line;
  std::cout << "ready" << std::endl;
  std::getline(std::cin, line);
  std::vector<double> begins;
  const double begin = now(), processor = processorSeconds();
  for (int i = 0; i < what.steps; i++) {
    begins.push_back(now());
    publish();
    if (what.pause == 0) continue;
    awaitPublished(step);
    std::this_thread::sleep_for(std::chrono::duration<double>(what.pause));
  }
  awaitPublished(step);
  const nlohmann::json result{{"begin", begin},
                              {"end", now()},
                              {"processor seconds", processorSeconds() - processor},
                              {"begins", begins}};
  std::cout << result.dump() << std::endl;
  std::getline(std::cin, line);  // The stream lives until all is asked that is to be known of it.
}

}  // namespace gxy::bench
