// SPDX-License-Identifier: Apache-2.0
#include "gxy/render/ready_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace gxy {
namespace {

std::string order(ReadyQueue& queue, std::string& ran) {
  while (const auto task = queue.pop()) task();
  return ran;
}

TEST(ReadyQueue, ServesInteractiveTasksFirst) {
  ReadyQueue queue;
  std::string ran;
  for (int i = 0; i < 3; i++) queue.push({1, false}, [&] { ran += 'b'; });
  queue.push({2, true}, [&] { ran += 'I'; });
  EXPECT_EQ(order(queue, ran), "Ibbb");
  EXPECT_TRUE(queue.empty());
}

TEST(ReadyQueue, ServesTenantsInTurnHoweverManyTasksTheyHave) {
  ReadyQueue queue;
  std::string ran;
  for (int i = 0; i < 6; i++) queue.push({1, false}, [&] { ran += 'a'; });
  for (int i = 0; i < 2; i++) queue.push({2, false}, [&] { ran += 'b'; });
  queue.push({3, false}, [&] { ran += 'c'; });
  EXPECT_EQ(order(queue, ran), "abcabaaaa");
}

TEST(ReadyQueue, KeepsTheOrderOfATenantsTasks) {
  ReadyQueue queue;
  std::string ran;
  for (const char c : std::string("12345")) queue.push({7, true}, [&ran, c] { ran += c; });
  EXPECT_EQ(order(queue, ran), "12345");
}

TEST(ReadyQueue, TheRestOfATaskComesBeforeTheOthersOfItsTenant) {
  ReadyQueue queue;
  std::string ran;
  queue.push({1, false}, [&] {
    queue.push(
        {1, false}, [&] { ran += 'r'; }, true);
  });
  queue.push({1, false}, [&] { ran += 'n'; });
  queue.push({2, false}, [&] { ran += 'o'; });
  EXPECT_EQ(order(queue, ran), "orn");
}

TEST(ReadyQueue, WhoComesLateWaitsForOneTaskOfEachOther) {
  ReadyQueue queue;
  std::string ran;
  for (int i = 0; i < 500; i++) queue.push({1, false}, [&] { ran += 'a'; });
  for (int i = 0; i < 100; i++) queue.pop()();
  queue.push({2, false}, [&] { ran += 'b'; });
  queue.pop()();
  EXPECT_EQ(ran.back(), 'b') << "served never, so longest ago";
}

}  // namespace
}  // namespace gxy
