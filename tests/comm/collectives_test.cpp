// SPDX-License-Identifier: Apache-2.0
#include "core/comm/collectives.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

TEST(Agree, TheLowestRankThatFailedIsToldOnAll) {
  test::ThreadRanks ranks(4);
  const auto errors = ranks.run([](Collectives& mine) {
    agree(mine, [&] {
      if (mine.rank() >= 2) throw std::runtime_error("disk " + std::to_string(mine.rank()) + " is full");
    });
  });
  EXPECT_EQ(errors, std::vector<std::string>(4, "rank 2: disk 2 is full"));
}

TEST(Agree, AnErrorWithoutTextIsAnErrorAllTheSame) {
  test::ThreadRanks ranks(2);
  const auto errors = ranks.run([](Collectives& mine) {
    agree(mine, [&] {
      if (mine.rank() == 1) throw Error("");
    });
  });
  EXPECT_EQ(errors, std::vector<std::string>(2, "rank 1: "));
}

TEST(Agree, ASingleRankIsNotNamed) {
  SingleRank one;
  try {
    agree(one, [] { throw Error("disk is full"); });
    FAIL() << "an error was expected";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "disk is full");
  }
}

TEST(GatherCounts, GivesThoseOfEveryRankByRank) {
  test::ThreadRanks ranks(3);
  const auto errors = ranks.run([](Collectives& mine) {
    EXPECT_EQ(gatherCounts(mine, uint64_t(10 + mine.rank())), (std::vector<uint64_t>{10, 11, 12}));
    EXPECT_EQ(sumOfCounts(mine, uint64_t(10 + mine.rank())), 33u);
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(ReduceValues, JoinsThoseOfAllRanksOneByOne) {
  test::ThreadRanks ranks(5);
  const auto errors = ranks.run([](Collectives& mine) {
    std::vector<int> values{mine.rank(), -mine.rank(), 7};
    reduceValues(mine, std::span(values), [](int a, int b) { return std::max(a, b); });
    EXPECT_EQ(values, (std::vector<int>{4, 0, 7}));
  });
  EXPECT_EQ(errors, std::vector<std::string>(5));
}

TEST(ReduceValues, RanksThatGiveDifferentNumbersOfThemAllFail) {
  test::ThreadRanks ranks(3);
  const auto errors = ranks.run([](Collectives& mine) {
    std::vector<int> values(size_t(mine.rank() == 1) + 1);
    reduceValues(mine, std::span(values), std::plus<>());
  });
  EXPECT_EQ(errors, std::vector<std::string>(3, "collective operation: ranks disagree about its size"));
}

TEST(GatherValues, RanksThatGiveDifferentNumbersOfThemAllFail) {
  test::ThreadRanks ranks(2);
  const auto errors = ranks.run([](Collectives& mine) {
    const std::vector<int> values(size_t(mine.rank()) + 1);
    gatherValues(mine, std::span<const int>(values));
  });
  for (const std::string& error : errors) EXPECT_NE(error.find("disagree about its size"), std::string::npos);
}

}  // namespace
}  // namespace gxy
