// SPDX-License-Identifier: Apache-2.0
// Works for tests, and what calling them must bring.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gxy/comm/collective.h"
#include "gxy/comm/error.h"
#include "gxy/comm/random.h"
#include "gxy/comm/wire.h"
#include "gxy/comm/work.h"

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

/// Adds "gather": a work in which the ranks wait for each other.
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
}

/// From one rank, on a thread that may wait; "gather" is there on all.
inline void checkWaitingCalls(Work& work, int ranks) {
  EXPECT_EQ(work.call(ranks - 1, "sum", {{"a", 1}, {"b", 2}})["sum"], 3 + ranks - 1);
  EXPECT_EQ(work.callAll("echo", "text").size(), size_t(ranks));
  for (const auto& sum : work.callAll("gather", {{"key", 7}})) EXPECT_EQ(sum, 7 * ranks);
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
