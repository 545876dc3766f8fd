// SPDX-License-Identifier: Apache-2.0
// killed_simulation OPTIONS RANK RANKS SEED START - one rank of a simulation that publishes until it is killed. Ranks do not wait
// for each other; as they began together, at START (nanoseconds of the steady clock), a step takes 2 ms, and a rank that was late catches up.
#include <sys/prctl.h>

#include <csignal>
#include <thread>

#include "tests/insitu/killed_simulation.h"

int main(int argc, char** argv) {
  using namespace gxy;
  using namespace gxy::test;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (argc != 6) return 2;
  const int rank = std::stoi(argv[2]), ranks = std::stoi(argv[3]);
  MiniSimulation simulation("heat", killedGrid(), killedBlocks(std::stoull(argv[4]), ranks), ranks,
                            killedFields(), Layout::Ghosts, argv[1], GXY_OF_POINTS, rank);
  if (simulation.results() != 0) return 1;
  auto next = std::chrono::steady_clock::time_point(std::chrono::nanoseconds(std::stoll(argv[5])));
  for (;;) {
    simulation.publish();
    next += std::chrono::milliseconds(2);
    std::this_thread::sleep_until(next);
  }
}
