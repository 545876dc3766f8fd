// SPDX-License-Identifier: Apache-2.0
// Works for tests, and what calling them must bring.
#pragma once
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <string>

#include "core/comm/collective.h"
#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/comm/wire.h"
#include "core/comm/work.h"

namespace gxy {

inline void addWorks(Work& work, int rank) {
  work.add("sum", [rank](const Work::Call& call) -> nlohmann::json {
    const double sum = call.parameters.at("a").get<double>() + call.parameters.at("b").get<double>() + rank;
    return {{"sum", sum}, {"sender", call.sender}, {"bytes", call.attachment.size()}};
  });
  work.add("fail on odd ranks", [rank](const Work::Call&) -> nlohmann::json {
    if (rank % 2) throw Error("no object 'density'");
    return true;
  });
  work.add("throw a number", [](const Work::Call&) -> nlohmann::json { throw 7; });
  work.add("echo", [](const Work::Call& call) { return call.parameters; });
}

/// Adds "gather" and "gather long": works in which the ranks wait for each other. And "nice" with each of the kinds of work,
/// the nice values of the threads that they run on.
inline void addCollectiveWork(Work& work, Collective& collective) {
  const auto gather = [&collective](const Work::Call& call) -> nlohmann::json {
    const auto key = call.parameters.at("key").get<uint64_t>();
    Writer writer;
    const auto all = collective.allGather(key, writer.write(key).take());
    uint64_t sum = 0;
    for (const auto& part : all) sum += Reader(part, "part").read<uint64_t>();
    collective.finish(key);
    return sum;
  };
  work.add("gather", gather, Work::Runs::Waiting);
  work.add("gather long", gather, Work::Runs::Long);
  const auto nice = [](const Work::Call&) -> nlohmann::json { return getpriority(PRIO_PROCESS, 0); };
  work.add("nice short", nice, Work::Runs::Short);
  work.add("nice waiting", nice, Work::Runs::Waiting);
  work.add("nice long", nice, Work::Runs::Long);
}

/// From one rank, on a thread that may wait; "gather" is there on all.
inline void checkWaitingCalls(Work& work, int ranks) {
  EXPECT_EQ(work.call(ranks - 1, "sum", {{"a", 1}, {"b", 2}})["sum"], 3 + ranks - 1);
  EXPECT_EQ(work.callAll("echo", "text").size(), size_t(ranks));
  for (const auto& sum : work.callAll("gather", {{"key", 7}})) EXPECT_EQ(sum, 7 * ranks);
  for (const auto& sum : work.callAll("gather long", {{"key", 8}})) EXPECT_EQ(sum, 8 * ranks);
  const auto ordinary = work.callAll("nice short", {}), lower = work.callAll("nice long", {});
  EXPECT_EQ(work.callAll("nice waiting", {}), ordinary);
  for (size_t r = 0; r < size_t(ranks); r++) {
    if (ordinary[r] < 19) {
      EXPECT_GT(lower[r], ordinary[r]) << "works of rank " << r << " that compute long";
    }
  }
  std::string message;
  try {
    work.callAll("fail on odd ranks", {});
  } catch (const Error& error) {
    message = error.what();
  }
  std::string expected;
  for (int r = 1; r < ranks; r += 2)
    expected += (r > 1 ? "; rank " : "rank ") + std::to_string(r) + ": no object 'density'";
  EXPECT_EQ(message, expected);
}

}  // namespace gxy
