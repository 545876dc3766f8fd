// SPDX-License-Identifier: Apache-2.0
#include "core/flow/node_key.h"

#include <gtest/gtest.h>

#include <set>

#include "core/flow/sha256.h"

namespace gxy::flow {
namespace {

std::string hexOf(const Sha256::Digest& digest) {
  std::string out;
  for (uint8_t byte : digest) {
    out += "0123456789abcdef"[byte >> 4];
    out += "0123456789abcdef"[byte & 15];
  }
  return out;
}

TEST(Sha256, GivesTheDigestsOfTheStandardsExamples) {
  const auto digestOf = [](std::string_view text) {
    Sha256 hash;
    hash.add(text);
    return hexOf(hash.digest());
  };
  EXPECT_EQ(digestOf(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digestOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digestOf("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, AMillionLettersInUnevenPiecesGiveTheStandardsDigest) {
  Sha256 hash;
  for (size_t left = 1000000, piece = 1; left > 0; left -= std::min(left, piece), piece = piece % 150 + 1)
    hash.add(std::string(std::min(left, piece), 'a'));
  EXPECT_EQ(hexOf(hash.digest()), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(NodeKey, DependsOnEverythingThatItIsMadeOf) {
  const SourceGeneration a{{7}, 1}, newer{{7}, 2}, other{{8}, 1};
  std::set<NodeKey> keys;
  size_t made = 0;
  const auto add = [&](const std::string& filter, int version, const std::string& properties,
                       const std::vector<KeyInput>& inputs) {
    keys.insert(keyOf(filter, version, properties, inputs));
    made++;
  };
  add("F", 1, "{}", {{"x", {a}}});
  add("G", 1, "{}", {{"x", {a}}});
  add("F", 2, "{}", {{"x", {a}}});
  add("F", 1, R"({"by":1})", {{"x", {a}}});
  add("F", 1, "{}", {{"y", {a}}});
  add("F", 1, "{}", {{"x", {newer}}});
  add("F", 1, "{}", {{"x", {other}}});
  add("F", 1, "{}", {{"x", {keyOf("F", 1, "{}", {})}}});
  add("F", 1, "{}", {{"x", {a, other}}});
  add("F", 1, "{}", {{"x", {other, a}}});
  add("F", 1, "{}", {{"x", {a}}, {"y", {other}}});
  add("F", 1, "{}", {{"x", {other}}, {"y", {a}}});
  add("F", 1, "{}", {});
  add("F1", 1, "{}", {});
  EXPECT_EQ(keys.size(), made);
}

TEST(NodeKey, DoesNotDependOnTheOrderOfInputs) {
  const SourceGeneration a{{7}, 1}, b{{8}, 1};
  EXPECT_EQ(keyOf("F", 1, "{}", {{"x", {a}}, {"y", {b}}}), keyOf("F", 1, "{}", {{"y", {b}}, {"x", {a}}}));
}

}  // namespace
}  // namespace gxy::flow
