// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace gxy::protocol {
namespace {

TEST(Printable, TextKeepsWhatIsSeenAndNothingThatATerminalObeys) {
  const std::string plain = "a\tb\n\u00e9 \u20ac \U0001F600 \u00a0";
  EXPECT_EQ(printable(plain), plain);
  EXPECT_EQ(printable("\x1b[2J\r\x7f"), "\uFFFD[2J\uFFFD\uFFFD");
  EXPECT_EQ(printable("\u0080\u009b31m\u009f"), "\uFFFD\uFFFD31m\uFFFD");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\uFFFD");
  EXPECT_EQ(printable("\xA0 \xFF\xC3"), "\uFFFD \uFFFD\uFFFD") << "what is no UTF-8, byte by byte";
  EXPECT_EQ(printable("\xED\xA0\x80 \xE2\x82"), "\uFFFD\uFFFD\uFFFD \uFFFD\uFFFD");
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, JsonStaysTheSameValue) {
  const nlohmann::json value{{"k\u009b", "\x1b \x7f \u0080 \u009f \u00a0 \u00e9"}};
  const std::string line = printableJson(value.dump());
  EXPECT_EQ(printable(line), line);
  EXPECT_EQ(nlohmann::json::parse(line), value);
}

}  // namespace
}  // namespace gxy::protocol
