// SPDX-License-Identifier: Apache-2.0
#include "core/io/part_document.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

const std::string kPart = R"({"parts":[{"extent":[0,1,2,3,4,5.5],"filename":"a_0.vtu"},
                                       {"extent":[1,2,2,3,4,5.5],"filename":"a_1.vtu"}]})";

TEST(Part, IsReadAsDocumented) {
  const auto parts = parsePart(kPart, "f");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].extent, (Box{{0, 2, 4}, {1, 3, 5.5}}));
  EXPECT_EQ(parts[1].file, "a_1.vtu");
  EXPECT_EQ(parsePart(formatPart(parts), "f")[1].extent, parts[1].extent);
}

TEST(Part, SocketSourcesAreAClearError) {
  try {
    parsePart(R"({"parts":[{"extent":[0,1,0,1,0,1],"host":"h","port":1900}]})", "f");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(
        std::string(e.what()),
        "f: part 0: pieces sent over a socket (\"host\", \"port\") are not supported; expected \"filename\"");
  }
}

TEST(Part, DamagedTextsGiveAnErrorOrNamedParts) {
  const testing::QuietLog quiet;
  std::mt19937 random(5);
  int errors = 0;
  for (int i = 0; i < 2000; ++i) {
    try {
      for (const GeometryPart& part : parsePart(testing::mutated(kPart, random), "f"))
        EXPECT_FALSE(part.file.empty());
    } catch (const Error& e) {
      ++errors;
      EXPECT_EQ(std::string(e.what()).find("f:"), 0u);
    }
  }
  EXPECT_GT(errors, 500);
}

}  // namespace
}  // namespace gxy
