// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/frames_asked.h"

#include <gtest/gtest.h>

namespace gxy::test {
namespace {

FramesAsked asked(int count) {
  FramesAsked frames;
  for (int i = 0; i < count; i++) frames.ask({});
  return frames;
}

TEST(FramesAsked, AreUnderWayUntilSomethingOfThemIsShown) {
  FramesAsked frames = asked(2);
  frames.number(1);
  frames.number(2);
  EXPECT_EQ(frames.underWay(), 2u);
  EXPECT_NE(frames.find(1), nullptr);
  frames.done(1);
  EXPECT_EQ(frames.underWay(), 1u);
  EXPECT_EQ(frames.find(1), nullptr);
  frames.done(2);
  EXPECT_EQ(frames.underWay(), 0u);
}

TEST(FramesAsked, AreOverWithTheOnesAfterThem) {
  FramesAsked frames = asked(2);
  frames.number(1);
  frames.number(2);
  frames.done(3);  // of newer data, say
  EXPECT_EQ(frames.underWay(), 0u);
  EXPECT_EQ(frames.newest(), 3u);
}

TEST(FramesAsked, MayBeShownBeforeTheirNumberIsKnown) {
  FramesAsked frames = asked(1);
  frames.done(1);
  EXPECT_EQ(frames.underWay(), 1u);
  frames.number(1);
  EXPECT_EQ(frames.underWay(), 0u);
}

// Frame 2 waits and newer data make frame 3: the end of 2 comes before the pixels of 1.
TEST(FramesAsked, OneThatWasOvertakenLeavesTheOneBeforeItUnderWay) {
  FramesAsked frames = asked(2);
  frames.number(1);
  frames.number(2);
  frames.skip(2);
  EXPECT_EQ(frames.underWay(), 1u);
  EXPECT_NE(frames.find(1), nullptr);
  EXPECT_EQ(frames.newest(), 2u);
}

TEST(FramesAsked, OneMayBeOvertakenBeforeItsNumberIsKnown) {
  FramesAsked frames = asked(2);
  frames.number(1);
  frames.skip(2);
  frames.number(2);
  EXPECT_EQ(frames.underWay(), 1u);
  EXPECT_NE(frames.find(1), nullptr);
}

TEST(FramesAsked, TheOldestWithoutAReplyIsTheOneRefused) {
  FramesAsked frames = asked(2);
  frames.number(7);
  frames.refuse();
  EXPECT_EQ(frames.underWay(), 1u);
  EXPECT_NE(frames.find(7), nullptr);
}

}  // namespace
}  // namespace gxy::test
