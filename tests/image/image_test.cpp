// SPDX-License-Identifier: Apache-2.0
#include "core/image/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "core/comm/error.h"
#include "core/comm/plugin.h"
#include "core/image/image_plugin.h"
#include "core/image/replace_file.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

using test::TemporaryFolder;

/// 2 x 2: opaque red, half-transparent green (premultiplied), nothing, and over-bright blue.
Image sample() { return {2, 2, {1, 0, 0, 1, 0, 0.25f, 0, 0.5f, 0, 0, 0, 0, -0.5f, 0.2f, 1.7f, 1}}; }

TEST(Image, FloatFormatsAreExact) {
  const TemporaryFolder folder;
  writeImage(folder / "a.exr", sample());
  writeImage(folder / "a.raw", sample());
  EXPECT_EQ(readImage(folder / "a.exr").rgba, sample().rgba);
  EXPECT_EQ(readImage(folder / "a.raw", 2, 2).rgba, sample().rgba);
}

TEST(Image, PngClampsRoundsAndKeepsRowOrder) {
  const TemporaryFolder folder;
  writeImage(folder / "a.png", sample());
  const Image got = readImage(folder / "a.png");
  ASSERT_EQ(got.width, 2);
  ASSERT_EQ(got.height, 2);
  const float half = 128 / 255.f;  // 0.5 rounds to 128, and so does 0.25 / 0.5
  const std::vector<float> expected{1, 0, 0, 1, 0, half * half, 0, half, 0, 0, 0, 0, 0, 51 / 255.f, 1, 1};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(got.rgba[i], expected[i], 1e-6) << i;
}

TEST(Image, EveryChannelIsClampedAlphaToo) {
  const std::vector<float> rgba{3, 0.5f, -1, 2, 0.25f, 0.25f, 0.25f, -1, 0, NAN, 0, NAN};
  EXPECT_EQ(eightBits(rgba), (std::vector<uint8_t>{255, 64, 0, 255, 64, 64, 64, 0, 0, 0, 0, 0}));
}

/// All levels of colour and opacity, and values between, beside and beyond them.
Image gradients() {
  Image image{67, 59, {}};
  for (int y = 0; y < image.height; y++)
    for (int x = 0; x < image.width; x++) {
      const float alpha = float(y) / 50, red = (float(x) / 60 - 0.02f) * alpha;
      for (const float value : {red, alpha / 3, x % 5 ? 0.7f * alpha : NAN, alpha})
        image.rgba.push_back(value);
    }
  return image;
}

// libpng, which writes them, and OpenImageIO, which wrote them before and reads them.
TEST(Image, BothWritersOfPngsGiveTheSamePixels) {
  const TemporaryFolder folder;
  for (const Image& image : {sample(), gradients()}) {
    const std::vector<std::byte> own = encodeImage("png", image);
    const std::vector<std::byte> other = plugin<ImagePlugin>("image", "a test").encode("png", image);
    replaceFile(folder / "own.png", own);
    replaceFile(folder / "other.png", other);
    const Image a = readImage(folder / "own.png"), b = readImage(folder / "other.png");
    EXPECT_EQ(a.width, image.width);
    EXPECT_EQ(a.height, image.height);
    EXPECT_EQ(a.rgba, b.rgba);
    const std::vector<uint8_t> levels = eightBits(image.rgba);
    for (size_t i = 0; i < levels.size(); i++) {
      const float scale = i % 4 == 3 ? 1.f : float(levels[i | 3]) / 255;
      ASSERT_NEAR(a.rgba[i], float(levels[i]) / 255 * scale, 1e-6) << i;
    }
  }
}

TEST(Image, WrongSizesAndUnknownKindsAreErrors) {
  const TemporaryFolder folder;
  writeImage(folder / "a.raw", sample());
  EXPECT_THROW(readImage(folder / "a.raw", 3, 2), Error);
  EXPECT_THROW(readImage(folder / "a.raw"), Error);
  EXPECT_THROW(readImage(folder / "none.png"), Error);
  EXPECT_THROW(writeImage(folder / "a.gif", sample()), Error);
  EXPECT_THROW(writeImage(folder / "no/such/folder.png", sample()), Error);
  EXPECT_THROW(writeImage(folder / "a.png", {2, 3, sample().rgba}), Error);
}

}  // namespace
}  // namespace gxy
