// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/file_watch.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace gxy::test {
namespace {

TEST(FileWatch, TellsOfEachChangeOnceAndOfNoneWhileTheFileIsAway) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "state.json";
  std::ofstream(path) << "one";
  FileWatch watch(path);
  FileWatch::Clock::time_point now{};
  const auto changed = [&] { return watch.changed(now += std::chrono::seconds(1)); };
  EXPECT_FALSE(changed());
  std::ofstream(path) << "other";
  EXPECT_TRUE(changed());
  EXPECT_FALSE(changed());
  std::filesystem::remove(path);
  EXPECT_FALSE(changed());
  std::ofstream(path) << "again";
  std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(5));
  EXPECT_TRUE(changed());
  EXPECT_FALSE(changed());
}

TEST(FileWatch, LooksTwiceASecond) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "state.json";
  FileWatch watch(path);
  FileWatch::Clock::time_point now{};
  EXPECT_FALSE(watch.changed(now));
  std::ofstream(path) << "one";
  EXPECT_FALSE(watch.changed(now + std::chrono::milliseconds(499)));
  EXPECT_TRUE(watch.changed(now + std::chrono::milliseconds(500)));
}

}  // namespace
}  // namespace gxy::test
