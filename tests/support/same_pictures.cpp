// SPDX-License-Identifier: Apache-2.0
// same_pictures [--backend=NAME] [--close] [--size=WxH] EXPECTED FOUND: compares pictures for scripts, by the
// rule of difference.h. Pictures must be equal bit for bit. With --close, or if NAME is vulkan and the tests'
// device is a GPU, the rule of close_pictures.h applies. For .raw pictures the size must be given, and the
// depths beside them (.depth) are compared too. Exit status: 0 if they are the same, 1 if not, 2 for wrong
// usage or a file that cannot be read.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/image/image.h"
#include "tests/support/difference.h"

namespace gxy::test {
namespace {

Picture read(const std::filesystem::path& path, int width, int height) {
  Image image = readImage(path, width, height);
  Picture picture{image.width, image.height, std::move(image.rgba), {}};
  const std::filesystem::path depths = std::filesystem::path(path).replace_extension(".depth");
  if (path.extension() != ".raw" || !std::filesystem::exists(depths)) return picture;
  picture.depth.resize(picture.rgba.size() / 4);
  const auto bytes = std::streamsize(picture.depth.size() * sizeof(double));
  std::ifstream file(depths, std::ios::binary);
  file.read(reinterpret_cast<char*>(picture.depth.data()), bytes);
  if (file.gcount() != bytes || file.peek() != EOF)
    throw Error(depths.string() + ": expected " + std::to_string(bytes) + " bytes");
  return picture;
}

int run(const std::vector<std::string>& args) {
  int width = 0, height = 0;
  bool close = false;
  std::vector<std::string> files;
  for (const std::string& arg : args) {
    if (arg == "--close")
      close = true;
    else if (arg.starts_with("--size=")) {
      if (std::sscanf(arg.c_str(), "--size=%dx%d", &width, &height) != 2) throw Error("expected --size=WxH");
    } else if (!arg.starts_with("--backend="))  // testedSameness() reads it
      files.push_back(arg);
  }
  if (files.size() != 2) throw Error("expected two pictures");
  const std::string words = difference(read(files[0], width, height), read(files[1], width, height),
                                       close ? Sameness::Close : testedSameness());
  if (words.empty()) return 0;
  std::fprintf(stderr, "%s is not %s: %s\n", files[1].c_str(), files[0].c_str(), words.c_str());
  return 1;
}

}  // namespace
}  // namespace gxy::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    return gxy::test::run({argv + 1, argv + argc});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "same_pictures: %s\n", e.what());
    return 2;
  }
}
