// SPDX-License-Identifier: Apache-2.0
#include "core/rays/packet_size.h"

#include <gtest/gtest.h>

#include <vector>

namespace gxy {
namespace {

using std::chrono::microseconds;

TEST(PacketSize, GrowsToTheMostWhileRaysAreCheap) {
  PacketSize size(1024);
  std::vector<int> sizes;
  for (int i = 0; i < 8; i++) {
    sizes.push_back(size.rays());
    size.took(size.rays(), microseconds(size.rays() / 4));
  }
  EXPECT_EQ(sizes, (std::vector<int>{16, 32, 64, 128, 256, 512, 1024, 1024}));
}

TEST(PacketSize, KeepsTheWorkOfAPacketBelowItsMost) {
  for (const int microsecondsPerRay : {1, 3, 10, 30, 70, 300}) {
    PacketSize size(1024);
    for (int i = 0; i < 20; i++) {
      const microseconds work(size.rays() * microsecondsPerRay);
      EXPECT_LE(work, PacketSize::kMostWork) << microsecondsPerRay;
      size.took(size.rays(), work);
    }
  }
}

TEST(PacketSize, StaysWithinItsBounds) {
  PacketSize size(1024), few(16);
  for (int i = 0; i < 10; i++) {
    size.took(size.rays(), std::chrono::seconds(1));
    few.took(few.rays(), std::chrono::seconds(1));
  }
  EXPECT_EQ(size.rays(), PacketSize::kFewest);
  EXPECT_EQ(few.rays(), 16);
  few.took(16, microseconds(1));
  EXPECT_EQ(few.rays(), 16);
  // a short packet that is cheap says nothing of a long one
  size.took(3, microseconds(1));
  EXPECT_EQ(size.rays(), PacketSize::kFewest);
}

TEST(PacketSize, CountsProcessorTimeOfTheThreadOnly) {
  const auto begin = PacketSize::processorTime();
  volatile double x = 1;
  for (int i = 0; i < 100000; i++) x = x * 1.0000001;
  EXPECT_GT(PacketSize::processorTime(), begin);
}

}  // namespace
}  // namespace gxy
