// SPDX-License-Identifier: Apache-2.0
#include "core/comm/trace.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

namespace gxy {
namespace {

using nlohmann::json;

json eventsOf(const Trace& trace, int rank = 0) {
  const json document = json::parse(Trace::document({trace.events(rank)}));
  return document.at("traceEvents");
}

TEST(Trace, HoldsStagesWithTheirThreadsTimesAndValues) {
  Trace trace;
  {
    const Trace::Span outer(&trace, "outer", 7);
    const Trace::Span inner(&trace, "inner \"quoted\" and longer than there is room for");
  }
  std::thread([&] { const Trace::Span other(&trace, "other"); }).join();
  trace.addLong("frame", 12, Trace::Clock::now());
  const json events = eventsOf(trace, 3);
  ASSERT_EQ(events.size(), 6u) << "the name of the process, three stages, both ends of the long one";
  for (const json& e : events) EXPECT_EQ(e.at("pid"), 3);
  EXPECT_EQ(events[1].at("name"), "inner _quoted_ and long");
  EXPECT_EQ(events[2].at("name"), "outer");
  EXPECT_EQ(events[2].at("args").at("value"), 7);
  EXPECT_LE(events[2].at("ts"), events[1].at("ts")) << "one is inside the other";
  EXPECT_EQ(events[1].at("tid"), events[2].at("tid"));
  EXPECT_NE(events[3].at("tid"), events[2].at("tid"));
  EXPECT_EQ(events[4].at("ph"), "b");
  EXPECT_EQ(events[5].at("id"), 12);
}

TEST(Trace, KeepsTheNewestAndNoMore) {
  Trace trace(10);
  for (uint64_t i = 0; i < 25; i++) const Trace::Span span(&trace, "stage", i);
  std::set<uint64_t> values;
  for (const json& e : eventsOf(trace))
    if (e.at("ph") == "X") values.insert(e.at("args").at("value").get<uint64_t>());
  EXPECT_EQ(values, (std::set<uint64_t>{15, 16, 17, 18, 19, 20, 21, 22, 23, 24}));
}

TEST(Trace, OfSeveralThreadsIsWhole) {
  Trace trace(1000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; t++)
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; i++) const Trace::Span span(&trace, "stage");
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(eventsOf(trace).size(), 1001u);
}

}  // namespace
}  // namespace gxy
