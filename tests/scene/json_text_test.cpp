// SPDX-License-Identifier: Apache-2.0
#include "core/scene/json_text.h"

#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

std::string parseError(std::string_view text) {
  return errorOf([&] { parseJson(text, "t"); });
}

std::string position(std::string_view text) {
  const std::string message = parseError(text);
  return message.substr(0, message.find(": "));
}

TEST(JsonText, PositionsOfValuesAndKeysAreExact) {
  const JsonValue root =
      parseJson("{\n  \"a\" : [1, -2.5e3 ,\n\ttrue,null], \"b\\u0041\": {\"c\":\"x\\\"y\"}\n}", "t");
  EXPECT_EQ(root.at, (TextPosition{1, 1}));
  const JsonMember* a = root.find("a");
  ASSERT_TRUE(a && a->value.array());
  EXPECT_EQ(a->at, (TextPosition{2, 3}));
  EXPECT_EQ(a->value.at, (TextPosition{2, 9}));
  const JsonValue::Array& items = *a->value.array();
  ASSERT_EQ(items.size(), 4u);
  EXPECT_EQ(items[0].at, (TextPosition{2, 10}));
  EXPECT_EQ(items[1].at, (TextPosition{2, 13}));
  EXPECT_EQ(items[2].at, (TextPosition{3, 2}));
  EXPECT_EQ(items[3].at, (TextPosition{3, 7}));
  const JsonMember* b = root.find("bA");
  ASSERT_TRUE(b);
  EXPECT_EQ(b->at, (TextPosition{3, 14}));
  EXPECT_EQ(b->value.find("c")->at, (TextPosition{3, 26}));
  EXPECT_EQ(b->value.find("c")->value.at, (TextPosition{3, 30}));
  EXPECT_EQ(*b->value.find("c")->value.string(), "x\"y");
}

TEST(JsonText, PositionsAfterANumberThatEndsTheListAreExact) {
  const JsonValue root = parseJson("[[1],[2,3],4]", "t");
  EXPECT_EQ((*root.array())[1].at, (TextPosition{1, 6}));
  EXPECT_EQ((*(*root.array())[1].array())[1].at, (TextPosition{1, 9}));
  EXPECT_EQ((*root.array())[2].at, (TextPosition{1, 12}));
}

TEST(JsonText, ColumnsCountCharactersNotBytes) {
  const JsonValue root = parseJson("[\"\xC3\xA4\xE2\x82\xAC\", 1]", "t");
  EXPECT_EQ((*root.array())[1].at, (TextPosition{1, 8}));
}

TEST(JsonText, ByteOrderMarkIsSkipped) {
  EXPECT_EQ(parseJson("\xEF\xBB\xBF[]", "t").at, (TextPosition{1, 1}));
}

TEST(JsonText, SyntaxErrorsPointAtTheOffendingToken) {
  EXPECT_EQ(position(""), "t:1:1");
  EXPECT_EQ(position("{\"a\" 1}"), "t:1:6");
  EXPECT_EQ(position("[1,,2]"), "t:1:4");
  EXPECT_EQ(position("[1,\n]"), "t:2:1");
  EXPECT_EQ(position("[1,\n  tru]"), "t:2:3");
  EXPECT_EQ(position("[1] x"), "t:1:5");
  EXPECT_EQ(position("[1, 2"), "t:1:6");
  EXPECT_EQ(position("{\"a\":\n \"open"), "t:2:2");
  EXPECT_EQ(position("[\"a\\qb\"]"), "t:1:5");
  EXPECT_EQ(position("[1e999]"), "t:1:2");
}

TEST(JsonText, NonFiniteNumbersAreRejected) {
  EXPECT_NE(parseError("[1e999]").find("finite"), std::string::npos);
  parseError("[NaN]");
  parseError("[Infinity]");
  parseError("[-Infinity]");
}

TEST(JsonText, AKeyGivenTwiceIsAnErrorAtTheSecond) {
  EXPECT_EQ(parseError("{\"a\": 1,\n \"b\": 2,\n \"a\": 3}"),
            "t:3:2: `a`: given twice, first on line 1; expected once");
}

TEST(JsonText, DepthIsBounded) {
  const size_t depth = kMaxJsonDepth;
  EXPECT_NO_THROW(parseJson(std::string(depth, '[') + std::string(depth, ']'), "t"));
  EXPECT_NE(parseError(std::string(depth + 1, '[')).find("nested deeper"), std::string::npos);
  EXPECT_NE(parseError(std::string(5'000'000, '[')).find("nested deeper"), std::string::npos);
}

TEST(JsonText, SizeAndCountAreBounded) {
  EXPECT_NE(parseError(std::string(kMaxJsonBytes + 1, ' ')).find("expected at most"), std::string::npos);
  std::string many = "[0";
  for (size_t i = 0; i < kMaxJsonValues; ++i) many += ",0";
  EXPECT_NE(parseError(many + "]").find("more than"), std::string::npos);
}

TEST(JsonText, IntegralMeansWithoutFraction) {
  const JsonValue root = parseJson("[4, 4.0, 4.5, 40e-1, 18446744073709551615]", "t");
  const bool expected[] = {true, true, false, true, true};
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ((*root.array())[i].number()->integral, expected[i]) << i;
}

TEST(JsonText, DescriptionsAreShortAndPrintable) {
  const std::string text = parseJson("\"" + std::string(1000, 'x') + "\"", "t").describe();
  EXPECT_LT(text.size(), 80u);
  EXPECT_EQ(inQuotes("a\nb\x1b"), "\"a?b?\"");
  EXPECT_EQ(inQuotes("\u009b2J \u00a0\u00e4", '\''), "'?2J \u00a0\u00e4'");
}

}  // namespace
}  // namespace gxy
