// SPDX-License-Identifier: Apache-2.0
// gxydiff: how much two pictures differ.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/image/image.h"
#include "tools/number_option.h"
#include "tools/version_option.h"

namespace {

using gxy::Image;

struct Options {
  std::string a, b, output, size;
  double max = 0, fraction = 0;
  bool alpha = false;
};

/// Of all compared channels; a pixel differs by its worst channel. NaN against a number is infinite.
struct Difference {
  double max = 0, rms = 0, over = 0;  ///< over: fraction of pixels that differ by more than the level
  std::vector<float> pixels;          ///< per pixel
};

Difference compare(const Image& a, const Image& b, double level, int channels) {
  Difference d;
  double squares = 0;
  size_t above = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    double worst = 0;
    for (size_t c = 0; c < size_t(channels); ++c) {
      const float x = a.rgba[i + c], y = b.rgba[i + c];
      const bool same = x == y || (std::isnan(x) && std::isnan(y));
      double difference = same ? 0 : std::abs(double(x) - double(y));
      if (std::isnan(difference)) difference = INFINITY;
      worst = std::max(worst, difference);
      squares += difference * difference;
    }
    d.max = std::max(d.max, worst);
    above += worst > level;
    d.pixels.push_back(float(worst));
  }
  const double pixels = double(d.pixels.size());
  d.rms = std::sqrt(squares / (pixels * channels));
  d.over = double(above) / pixels;
  return d;
}

/// Grey, the largest difference white.
void writeDifference(const std::string& path, const Image& like, const Difference& d) {
  Image picture{like.width, like.height, {}};
  for (float worst : d.pixels) {
    const float grey = d.max > 0 ? float(std::isinf(worst) ? 1 : worst / d.max) : 0.f;
    picture.rgba.insert(picture.rgba.end(), {grey, grey, grey, 1.f});
  }
  gxy::writeImage(path, picture);
}

int run(const Options& options) {
  int width = 0, height = 0;
  if (!options.size.empty()) std::sscanf(options.size.c_str(), "%dx%d", &width, &height);
  const Image a = gxy::readImage(options.a, width, height), b = gxy::readImage(options.b, width, height);
  if (a.width != b.width || a.height != b.height) {
    std::printf("different: %d x %d and %d x %d pixels\n", a.width, a.height, b.width, b.height);
    return 1;
  }
  const Difference d = compare(a, b, options.max, options.alpha ? 4 : 3);
  const bool equal = d.over <= options.fraction;
  std::printf("%s: max %.6g (%.2f/255), rms %.6g, pixels over %.6g: %.6g %%\n", equal ? "equal" : "different",
              d.max, d.max * 255, d.rms, options.max, d.over * 100);
  if (!options.output.empty()) writeDifference(options.output, a, d);
  return equal ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Compares two pictures (.png, .exr, or .raw with --size), premultiplied.", "gxydiff");
  app.footer(R"(Examples:
  gxydiff a.png b.png                                 equal to the bit
  gxydiff a.png b.png --max 0.004 --fraction 0.001    at most one in 1000 pixels over 1/255
  gxydiff a.raw b.raw --size 1024x1024 --output difference.png
Exit status: 0 equal within the limits, 1 different, 2 wrong usage or a picture that cannot be read.)");
  Options options;
  app.add_option("a", options.a, "a picture")->required();
  app.add_option("b", options.b, "another picture")->required();
  app.add_option("--max", options.max,
                 "largest difference of a channel (1 is full scale) that counts as equal")
      ->check(gxy::numberFrom(0, 1e30));
  app.add_option("--fraction", options.fraction, "fraction of pixels that may differ by more")
      ->check(gxy::numberFrom(0, 1));
  app.add_option("--output", options.output, "write a picture of the differences");
  app.add_option("--size", options.size, "size of raw pictures, WIDTHxHEIGHT")
      ->check([](const std::string& text) {
        int width = 0, height = 0, used = 0;
        const bool right = std::sscanf(text.c_str(), "%6dx%6d%n", &width, &height, &used) == 2 &&
                           size_t(used) == text.size() && width > 0 && height > 0;
        return right ? std::string() : "expected WIDTHxHEIGHT, found '" + text + "'";
      });
  app.add_flag("--alpha", options.alpha, "compare alpha too");
  gxy::addVersion(app, "gxydiff");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gxydiff: %s\n", e.what());
    return 2;
  }
}
