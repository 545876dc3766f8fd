// SPDX-License-Identifier: Apache-2.0
#include "core/space/shared_by.h"

#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <string>

namespace gxy {
namespace {

TEST(SharedBy, MakesAValueOnceWhileSomebodyHoldsIt) {
  SharedBy<int, std::string> words;
  int made = 0;
  const auto get = [&](int key) {
    return words.get(key, [&] { return std::to_string(key) + "/" + std::to_string(made++); });
  };
  EXPECT_EQ(words.find(1), nullptr);
  const auto first = get(1);
  EXPECT_EQ(*first, "1/0");
  EXPECT_EQ(get(1), first);
  EXPECT_EQ(words.find(1), first);
  EXPECT_EQ(*get(2), "2/1");
  EXPECT_EQ(words.find(2), nullptr) << "nobody holds it";
  EXPECT_EQ(*get(2), "2/2");
}

TEST(SharedBy, MakesAgainWhatCouldNotBeMade) {
  SharedBy<int, std::string> words;
  EXPECT_THROW(words.get(1, []() -> std::string { throw std::runtime_error("no room"); }),
               std::runtime_error);
  EXPECT_EQ(words.find(1), nullptr);
  EXPECT_EQ(*words.get(1, [] { return std::string("there"); }), "there");
}

TEST(SharedBy, HasWhatIsThereOrBeingMade) {
  SharedBy<int, std::string> words;
  EXPECT_FALSE(words.has(1));
  auto there = words.get(1, [&] {
    EXPECT_TRUE(words.has(1));
    EXPECT_FALSE(words.has(2));
    return std::string("there");
  });
  EXPECT_TRUE(words.has(1));
  there.reset();
  EXPECT_FALSE(words.has(1));
}

TEST(SharedBy, OnlyWhoWantsTheSameWaitsAndMayGiveUp) {
  SharedBy<int, std::string> words;
  std::promise<void> begun, release;
  auto first = std::async(std::launch::async, [&] {
    return words.get(1, [&] {
      begun.set_value();
      release.get_future().wait();
      return std::string("first");
    });
  });
  begun.get_future().wait();
  EXPECT_EQ(*words.get(2, [] { return std::string("other"); }), "other");
  const auto never = []() -> std::string { throw std::logic_error("made twice"); };
  EXPECT_THROW(words.get(1, never, [] { throw std::runtime_error("given up"); }), std::runtime_error);
  std::promise<void> waits;
  auto second = std::async(std::launch::async, [&] {
    return words.get(1, never, [&, told = false]() mutable {
      if (!std::exchange(told, true)) waits.set_value();
    });
  });
  waits.get_future().wait();
  release.set_value();
  EXPECT_EQ(second.get(), first.get());
}

}  // namespace
}  // namespace gxy
