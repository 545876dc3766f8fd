// SPDX-License-Identifier: Apache-2.0
// The parts of insitu_bench.py that are timed: processes that do one thing and print a line of JSON about it.
#pragma once
#include <sys/resource.h>

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "core/data/volume.h"

namespace gxy::bench {

/// Seconds of the system's monotonic clock, the same in all processes.
inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Processor seconds of this process so far.
inline double processorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// A server, as options of gxy_open() name it; an empty address is none.
struct To {
  std::string address, tokenFile;
  nlohmann::json options() const;
};

/// The time of `calls` calls of gxy_publish() that are not taken, and what is sent meanwhile. With a server, its first step is taken
/// before: nobody else may ask for steps.
nlohmann::json publishes(const To& to, int calls);

/// The time of copies of a block of `points` points, by layout in memory, and of memcpy of as many bytes: the least of `repeats` each.
nlohmann::json copies(const Index3& points, int repeats);

/// Each of `senders` processes sends `bytes` bytes in chunks of 1 MiB, to each of `receivers` processes its share, `rounds` times.
nlohmann::json rawTcp(int senders, int receivers, uint64_t bytes, int rounds);

/// Two ends of a TCP connection over loopback.
void connectedPair(int ends[2]);

/// Processor seconds of both ends together for each GB that is copied into a slot and comes into the buffer of another process: by TCP, by a
/// Unix socket, and by a slot in memory that both have, of which the other reads 256 KiB at a time (memfd, pread).
nlohmann::json carries(uint64_t bytes, int rounds);

/// One rank of a simulation of `side`^3 floats that publishes each step and waits until it is taken: `warm` steps, then those that are
/// measured, from a line of standard input on. `pause`: seconds between steps, from the moment that one is published; 0: none, and the
/// simulation is ahead of the server by one step. Prints "ready" before that line, and a line of JSON after it. Ends with another line.
struct SimulatedRank {
  int rank = 0, ranks = 1, side = 0, warm = 1, steps = 1;
  double pause = 0;
};
void simulate(const To& to, const SimulatedRank& what);

}  // namespace gxy::bench
