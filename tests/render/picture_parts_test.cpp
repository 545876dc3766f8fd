// SPDX-License-Identifier: Apache-2.0
#include "core/render/picture_parts.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/comm/wire.h"

namespace gxy {
namespace {

TEST(PictureParts, HaveEachRowOnceAndARankHasOneOfThemAtMost) {
  for (int ranks = 1; ranks <= 40; ranks++)
    for (const int ranksPerPart : {1, 3, 16})
      for (const glm::ivec2 size : {glm::ivec2{5, 1}, {3, 7}, {2, 64}, {9, 65}})
        for (const uint64_t frame : {1, 38}) {
          const PictureParts parts(frame, size, ranks, ranksPerPart);
          ASSERT_GE(parts.count(), 1);
          ASSERT_LE(parts.count(), std::min(size.y, (ranks + ranksPerPart - 1) / ranksPerPart));
          std::set<int> owners;
          int next = 0;
          for (int part = 0; part < parts.count(); part++) {
            ASSERT_EQ(parts.rows(part).first, next);
            ASSERT_GE(parts.rows(part).count(), 1);
            next = parts.rows(part).end;
            ASSERT_EQ(parts.end(part), size_t(next * size.x));
            ASSERT_GE(parts.rank(part), 0);
            ASSERT_LT(parts.rank(part), ranks);
            owners.insert(parts.rank(part));
          }
          ASSERT_EQ(next, size.y);
          ASSERT_EQ(owners.size(), size_t(parts.count()));
          for (int rank = 0; rank < ranks; rank++) {
            const auto part = parts.ofRank(rank);
            ASSERT_EQ(part.has_value(), owners.count(rank) == 1);
            if (part) {
              ASSERT_EQ(parts.rank(*part), rank);
            }
          }
        }
}

TEST(PictureParts, AreOneWhereRanksAreFewAndGrowWithThem) {
  const glm::ivec2 size{1920, 1080};
  for (int ranks = 1; ranks <= 16; ranks++) EXPECT_EQ(PictureParts(7, size, ranks, 16).count(), 1);
  EXPECT_EQ(PictureParts(7, size, 17, 16).count(), 2);
  EXPECT_EQ(PictureParts(7, size, 64, 16).count(), 4);
  EXPECT_EQ(PictureParts(7, size, 1024, 16).count(), 64);
}

TEST(PictureParts, OfFramesThatFollowEachOtherAreOnOtherRanks) {
  std::vector<int> pictures(64), parts(64);
  for (uint64_t frame = 1; frame <= 64; frame++) {
    const PictureParts of(frame, {64, 64}, 64, 16);
    pictures[size_t(of.rank(0))]++;
    for (int part = 0; part < of.count(); part++) parts[size_t(of.rank(part))]++;
  }
  EXPECT_EQ(pictures, std::vector<int>(64, 1));
  EXPECT_EQ(parts, std::vector<int>(64, 4));
}

constexpr glm::ivec2 kSize{7, 23};
constexpr int kSamples = 2;
const PictureParts kParts(1, kSize, 5, 1);

Background gradient() {
  RenderSettings settings;
  settings.background = glm::dvec4{0.1, 0.2, 0.3, 1};
  settings.backgroundTop = glm::dvec4{0.9, 0.7, 0.5, 1};
  return settings;
}

// The same random light in one framebuffer and in one for each part; half of the rows stay empty.
struct Light {
  Light() : whole(kSize.x, kSize.y, kSamples, true) {
    for (int part = 0; part < kParts.count(); part++)
      parts.push_back(std::make_unique<Framebuffer>(kSize, kParts.rows(part), kSamples, true));
    Random random(9);
    for (int i = 0; i < 500; i++) {
      const auto pixel = uint32_t(random.below(uint64_t(kSize.x * kSize.y) / 2));
      const auto value = [&] { return int32_t(random.below(CONTRIBUTION_ONE)); };
      const Contribution c{pixel, value(), value(), value(), value()};
      const DepthContribution d{pixel, double(random.below(1000))};
      int takenBy = 0;
      for (const auto& part : parts) takenBy += part->add({&c, 1}) && part->addDepths({&d, 1});
      EXPECT_EQ(takenBy, 1) << "pixel " << pixel;
      EXPECT_TRUE(whole.add({&c, 1}) && whole.addDepths({&d, 1}));
    }
  }
  Framebuffer whole;
  std::vector<std::unique_ptr<Framebuffer>> parts;
};

Picture joinedOf(const std::vector<Bytes>& messages, bool sums = false, bool depth = true) {
  const std::vector<std::span<const std::byte>> views(messages.begin(), messages.end());
  return joined(kParts, sums, depth, views);
}

TEST(PictureParts, MakeThePictureOfTheWhole) {
  const Light light;
  std::vector<Bytes> messages;
  for (int part = kParts.count() - 1; part >= 0; part--)
    messages.push_back(bytesOfPart(part, light.parts[size_t(part)]->picture(gradient())));
  messages[0].insert(messages[0].end(), messages[2].begin(), messages[2].end());  // two parts in one message
  messages.erase(messages.begin() + 2);
  const Picture expected = light.whole.picture(gradient()), picture = joinedOf(messages);
  EXPECT_EQ(picture.width, kSize.x);
  EXPECT_EQ(picture.height, kSize.y);
  EXPECT_EQ(picture.rgba, expected.rgba);
  EXPECT_EQ(picture.depth, expected.depth);
  EXPECT_TRUE(picture.sums.empty());
}

TEST(PictureParts, MakeTheSumsOfTheWhole) {
  Light light;
  std::vector<Bytes> messages;
  for (int part = 0; part < kParts.count(); part++)
    messages.push_back(bytesOfPart(part, light.parts[size_t(part)]->takeSums()));
  const Picture expected = light.whole.takeSums(), picture = joinedOf(messages, true);
  EXPECT_EQ(picture.sums, expected.sums);
  EXPECT_EQ(picture.depth, expected.depth);
  EXPECT_EQ(picture.samples, kSamples);
  EXPECT_TRUE(picture.rgba.empty());
}

TEST(PictureParts, ThatAreMissingOrWrongMakeNoPicture) {
  const Light light;
  std::vector<Bytes> messages;
  for (int part = 0; part < kParts.count(); part++)
    messages.push_back(bytesOfPart(part, light.parts[size_t(part)]->picture(gradient())));
  const auto errorOf = [](const std::vector<Bytes>& with, bool sums = false, bool depth = true) {
    try {
      joinedOf(with, sums, depth);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const auto with = [&](size_t part, Bytes message) {
    std::vector<Bytes> changed = messages;
    changed[part] = std::move(message);
    return changed;
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    return testing::AssertionResult(text.find(part) != std::string::npos) << text;
  };
  EXPECT_EQ(errorOf(messages), "none");
  EXPECT_TRUE(contains(errorOf(with(2, {})), "part 2 of a picture of 5 has not come"));
  EXPECT_TRUE(contains(errorOf(with(2, messages[1])), "expected each of them once"));
  EXPECT_TRUE(contains(errorOf(with(2, bytesOfPart(2, "no memory"))),
                       "the part of the picture on rank " + std::to_string(kParts.rank(2)) + ": no memory"));
  EXPECT_TRUE(contains(errorOf(messages, true), "values, expected 0"));
  EXPECT_TRUE(contains(errorOf(messages, false, false), "values, expected 0"));
  EXPECT_TRUE(contains(errorOf(with(2, bytesOfPart(4, light.parts[4]->picture(gradient())))), "part 4"));
  for (size_t size = 0; size < messages[3].size(); size++) {
    Bytes shorter(messages[3].begin(), messages[3].begin() + ptrdiff_t(size));
    EXPECT_NE(errorOf(with(3, std::move(shorter))), "none") << size << " bytes";
  }
}

}  // namespace
}  // namespace gxy
