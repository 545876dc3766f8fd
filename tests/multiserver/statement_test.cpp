// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/statement.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"

namespace gxy::protocol {
namespace {

TEST(Statements, AreAVerbAndItsArguments) {
  EXPECT_EQ(parseStatement("list").verb, "list");
  EXPECT_EQ(parseStatement("  data.import\n{\"a\": 1} ; ").verb, "data.import");
  EXPECT_EQ(parseStatement("  data.import\n{\"a\": 1} ; ").arguments, "{\"a\": 1}");
  EXPECT_EQ(parseStatement("import{}").arguments, "{}");
  for (const char* wrong : {"", ";", "{}", "!", "list!", "\"list\""})
    EXPECT_THROW(parseStatement(wrong), Error) << wrong;
}

TEST(Statements, GiveTheirWordsOneByOne) {
  Arguments a("ball \"a; b \\\"c\\\"\" 2.5 {\"x\": 1}", "verb");
  EXPECT_EQ(a.expectWord(), "ball");
  EXPECT_EQ(a.expectWord(), "a; b \"c\"");
  EXPECT_EQ(a.number(), 2.5);
  EXPECT_EQ(a.word(), std::nullopt);
  EXPECT_EQ(a.expectJson(), "{\"x\": 1}");
  a.expectEnd();
  EXPECT_THROW(Arguments("{x}", "verb").expectWord(), Error) << "a word that begins with { is quoted";
  EXPECT_EQ(Arguments("\"{x}\"", "verb").expectWord(), "{x}");
  Arguments b("shared like ball", "verb");
  EXPECT_TRUE(b.taken("shared"));
  EXPECT_FALSE(b.taken("li"));
  EXPECT_TRUE(b.taken("like"));
  EXPECT_THROW(b.expectEnd(), Error);
  EXPECT_THROW(b.expectJson(), Error);
  EXPECT_THROW(Arguments("\"open", "verb").word(), Error);
  EXPECT_THROW(Arguments("1e999", "verb").number(), Error);
  EXPECT_THROW(Arguments("nan", "verb").number(), Error);
}

TEST(Scripts, AreCutAtSemicolonsOutsideOfStrings) {
  std::string rest;
  const auto cut = cutStatements("list;; import {\"name\": \"a;b\\\";\"} ; drop \"x;\"; wait x", rest);
  EXPECT_EQ(cut, (std::vector<std::string>{"list", "import {\"name\": \"a;b\\\";\"}", "drop \"x;\""}));
  EXPECT_EQ(rest, " wait x");
  EXPECT_TRUE(cutStatements("import {\"name\": \"a;", rest).empty());
  EXPECT_EQ(rest, "import {\"name\": \"a;");
}

TEST(Names, BecomeWordsThatMeanThem) {
  for (const std::string name : {"ball", "a b", "a\"b", "a;b", "{x}", "\\", "\xC3\xA9"}) {
    const std::string word = asWord(name);
    Arguments arguments(word, "verb");
    EXPECT_EQ(arguments.expectWord(), name);
    arguments.expectEnd();
  }
}

TEST(Text, ThatOthersAreShownMayBeCheckedForControlCharacters) {
  EXPECT_FALSE(hasControls("plain \xC3\xA9\xC2\xA0"));
  for (const char* text : {"a\nb", "\t", "\x7F", "\xC2\x80", "\xC2\x9F"})
    EXPECT_TRUE(hasControls(text)) << text;
}

TEST(Handshake, NamesThatAreShownToOthersHaveNoControlCharacters) {
  const auto hello = [](const std::string& client, const std::string& tenant) {
    return parseHello(helloText({"", client, tenant}));
  };
  EXPECT_EQ(hello("msdata \xC3\xA9", "ann").client, "msdata \xC3\xA9");
  for (const char* name : {"a\x1B[2J", "a\nclient 7: root",
                           "a\xC2\x9B"
                           "2J"}) {
    EXPECT_THROW(hello(name, "ann"), Error) << name;
    EXPECT_THROW(hello("msdata", name), Error) << name;
  }
}

TEST(Handshake, NamesHaveAtMost255Bytes) {
  const std::string longest(255, 'n');
  const Hello hello = parseHello(helloText({"", longest, longest}));
  EXPECT_EQ(hello.client, longest);
  EXPECT_EQ(hello.tenant, longest);
  EXPECT_THROW(parseHello(helloText({"", longest + "n", "ann"})), Error);
  EXPECT_THROW(parseHello(helloText({"", "client", longest + "n"})), Error);
}

TEST(Statements, HaveVerbsOfAtMost128Characters) {
  const std::string longest(128, 'v');
  EXPECT_EQ(parseStatement(longest + " word").verb, longest);
  EXPECT_THROW(parseStatement(longest + "v word"), Error);
}

}  // namespace
}  // namespace gxy::protocol
