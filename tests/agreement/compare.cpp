// SPDX-License-Identifier: Apache-2.0
#include "tests/agreement/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "core/image/image.h"
#include "tests/agreement/backend.h"
#include "tests/agreement/same_bits.h"
#include "tools/gxyrender/reference_scene.h"

namespace gxy::agreement {

namespace {

using reference::ReferenceOptions;
using reference::ReferencePicture;

constexpr double kMiss = 1e30;

struct PixelRange {
  std::array<double, 4> lo, hi;
  double nearest, farthest, farthestHit;  ///< depths; the last but for misses
};

double difference(const float* a, const double* b) {
  double largest = 0;
  for (int c = 0; c < 4; c++) {
    const double d = std::abs(double(a[c]) - b[c]);
    largest = d <= largest ? largest : std::isnan(d) ? kMiss : d;
  }
  return largest;
}

/// What depths are compared against: the longest side of the domain, or of a sphere that is larger than that.
double sizeOf(const TestScene& scene, const CompiledScene& compiled) {
  double longest = 1 / compiled.space.scale;
  for (size_t i = 0; i < scene.data.size(); i++) {
    if (!scene.data[i].geometry) continue;
    const Range& values = scene.data[i].geometry->range;
    longest = std::max(longest, 2 * largestRadius(scene.visualization.operators[i], values));
  }
  return longest;
}

/// Of a seed, so that those beside each other give unrelated numbers (Steele, Lea, Flood: SplitMix64, OOPSLA 2014).
uint64_t mixed(uint64_t seed) {
  uint64_t z = (seed + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// What the reference shows in one pixel over all perturbations.
class Perturbed {
 public:
  Perturbed(const TestScene& scene, const CompareOptions& options, ReferenceOptions how)
      : scene_(scene), reference_(scene.forReference()), options_(options), how_(std::move(how)) {
    how_.perturbation = options.perturbation;
    const auto& all = scene.visualization.operators;
    const auto rendered = [](const Vis& vis) { return vis.type == VisType::Volume && vis.volumeRendering; };
    if (std::count_if(all.begin(), all.end(), rendered) < 2) return;
    for (size_t i = 0; i < all.size(); i++) {
      if (!rendered(all[i]) || !scene.data[i].volume) continue;
      auto copy = std::make_shared<Volume>(*scene.data[i].volume);
      reference_.data[i] = copy;
      apart_.emplace_back(std::move(copy), scene.data[i].volume->grid.origin);
    }
  }

  PixelRange at(glm::ivec2 pixel, int seeds) {
    PixelRange range{{1e300, 1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300, -1e300}, kMiss, 0, 0};
    how_.first = pixel;
    how_.size = {1, 1};
    how_.threads = 1;
    for (int s = 0; s < seeds; s++) {
      const ReferencePicture one = moved(s);
      for (int c = 0; c < 4; c++) {
        range.lo[c] = std::min(range.lo[c], one.rgba[c]);
        range.hi[c] = std::max(range.hi[c], one.rgba[c]);
      }
      range.nearest = std::min(range.nearest, one.depth[0]);
      range.farthest = std::max(range.farthest, one.depth[0]);
      if (one.depth[0] < kMiss) range.farthestHit = std::max(range.farthestHit, one.depth[0]);
    }
    return range;
  }

  /// The whole picture, or what `at` was asked for last, by one of the perturbations.
  ReferencePicture moved(int seed) {
    how_.seed = uint64_t(seed);
    moveIsovalues(how_.seed);
    moveVolumes(how_.seed);
    ReferencePicture picture = reference::renderReference(reference_, scene_.camera, how_);
    reference::applyBackground(picture, scene_.settings);
    return picture;
  }

 private:
  /// By what the field may be off in float: ulps of its largest stored value, often far less, where cells hold nearly the
  /// isovalue.
  void moveIsovalues(uint64_t seed) {
    Uniform random(mixed(seed));
    for (size_t i = 0; i < scene_.data.size(); i++) {
      if (!scene_.data[i].volume) continue;
      const Volume& volume = *scene_.data[i].volume;
      const Vis& vis = unmoved_.operators[i];
      const size_t last = volume.ranges.size() - 1;
      const Range& range = volume.ranges[vis.component ? size_t(*vis.component) : last];
      const double largest = std::max(std::abs(range.min - volume.shift), std::abs(range.max - volume.shift));
      for (size_t k = 0; k < vis.isovalues.size(); k++) {
        const double unit =
            options_.perturbation * 0x1p-23 * largest * std::exp2(std::min(0.0, random.in(-20, 20)));
        reference_.visualization.operators[i].isovalues[k] = vis.isovalues[k] + unit * random.in(-1, 1);
      }
    }
  }

  /// By what volumes may be off against each other in float: which of two that begin together is seen first.
  void moveVolumes(uint64_t seed) {
    if (apart_.empty()) return;
    Uniform random(mixed(seed));
    const double unit = options_.perturbation * 0x1p-24 * sizeOf(scene_, *scene_.compile());
    for (auto& [volume, origin] : apart_) volume->grid.origin = origin + random.inCube(unit);
  }

  const TestScene& scene_;
  reference::ReferenceScene reference_;
  std::vector<std::pair<std::shared_ptr<Volume>, glm::dvec3>> apart_;  // rendered together, and their origins
  const Visualization unmoved_ = reference_.visualization;             // with isovalues as stored
  CompareOptions options_;
  ReferenceOptions how_;
};

void writePictures(const TestScene& scene, const Picture& mine, const ReferencePicture& truth) {
  const std::string prefix = testing::TempDir() + scene.name;
  Image image{mine.width, mine.height, mine.rgba};
  writeImage(prefix + "_backend.png", image);
  image.rgba.assign(truth.rgba.begin(), truth.rgba.end());
  writeImage(prefix + "_reference.png", image);
  for (size_t i = 0; i < image.rgba.size(); i++)
    image.rgba[i] = i % 4 == 3 ? 1.f : 8 * std::abs(mine.rgba[i] - float(truth.rgba[i]));
  writeImage(prefix + "_difference.png", image);
}

ReferenceOptions howToCompare(const TestScene& scene, const CompareOptions& options) {
  ReferenceOptions how;
  how.tolerance = 1e-5;
  if (scene.visualization.lighting.aoCount > 0) how.aoHook = backendDirections(scene, options.frameNumber);
  return how;
}

}  // namespace

reference::AoDirections backendDirections(const TestScene& scene, uint32_t frameNumber) {
  return occlusionDirections(scene.visualization.lighting.aoCount, scene.camera.dimensions.x, frameNumber);
}

Picture drawnByBoth(const TestScene& scene, uint32_t frameNumber) {
  Picture picture = draw(embree(), scene, frameNumber);
#ifdef GALAXY_VULKAN
  expectVulkanDrawsTheSame(picture, scene, frameNumber);
#endif
  return picture;
}

int pixelsThatMove(const TestScene& scene, const CompareOptions& options) {
  const ReferenceOptions how = howToCompare(scene, options);
  ReferencePicture truth = reference::renderReference(scene.forReference(), scene.camera, how);
  reference::applyBackground(truth, scene.settings);
  Perturbed perturbed(scene, options, how);
  int most = 0;
  for (int seed = 0; seed < options.seeds; seed++) {
    const ReferencePicture moved = perturbed.moved(seed);
    int changed = 0;
    for (size_t i = 0; i < truth.rgba.size(); i += 4) {
      bool differs = false;
      for (size_t c = i; c < i + 4; c++)
        differs = differs || !(std::abs(moved.rgba[c] - truth.rgba[c]) <= options.tolerance);
      changed += differs;
    }
    most = std::max(most, changed);
  }
  return most;
}

Comparison compare(const Backend& backend, const TestScene& scene, const CompareOptions& options) {
  const bool both = options.vulkan && backend.name() == "embree";
  const Picture mine =
      both ? drawnByBoth(scene, options.frameNumber) : draw(backend, scene, options.frameNumber);
  const ReferenceOptions how = howToCompare(scene, options);
  ReferencePicture truth = reference::renderReference(scene.forReference(), scene.camera, how);
  reference::applyBackground(truth, scene.settings);
  Perturbed perturbed(scene, options, how);

  Comparison result;
  result.pixels = mine.width * mine.height;
  const auto compiled = scene.compile();
  const double depthSlack = 4e-6 * sizeOf(scene, *compiled);
  std::ostringstream worst;
  worst << std::setprecision(7);
  int flipsShown = 0;
  const bool volumes = !compiled->rendered.empty();
  for (int i = 0; i < result.pixels; i++) {
    const float* a = &mine.rgba[4 * size_t(i)];
    const double* b = &truth.rgba[4 * size_t(i)];
    for (int c = 0; c < 4; c++) result.finite = result.finite && std::isfinite(a[c]);
    result.seen +=
        std::abs(b[3] - scene.settings.background.a) > 0.01 || truth.depth[i] < kMiss ||
        std::abs(b[0] - scene.settings.background.r) + std::abs(b[1] - scene.settings.background.g) > 0.01;
    const double d = difference(a, b);
    const bool depthDiffers =
        (mine.depth[i] < kMiss) != (truth.depth[i] < kMiss) ||
        !(std::abs(mine.depth[i] - truth.depth[i]) <= depthSlack + 4e-16 * std::abs(truth.depth[i]));
    const bool hidden = volumes && mine.depth[i] >= kMiss;  // a surface behind an opaque volume has no depth
    if (d <= options.tolerance && (!depthDiffers || hidden)) {
      result.largest = std::max(result.largest, d);
      continue;
    }
    const glm::ivec2 pixel(i % mine.width, i / mine.width);
    PixelRange range;
    bool colorWrong = true, depthWrong = true;
    // each ray of a pixel may move another way; depths near where a surface ends need moves near none
    const int rays = std::max(1, scene.settings.raysPerPixel);
    for (int seeds : {options.seeds, 10 * options.seeds,
                      1000 * options.seeds}) {  // what few moves change is seen in many
      if (!colorWrong && !depthWrong) break;
      range = perturbed.at(pixel, seeds);
      bool changes = false, among = true;
      for (int c = 0; c < 4; c++) {
        const double lo = std::min(range.lo[c], b[c]), hi = std::max(range.hi[c], b[c]);
        const double slack = options.tolerance + (rays - 1) * (hi - lo);
        changes = changes || hi - lo > 0.5 * options.tolerance;
        among = among && a[c] >= lo - slack && a[c] <= hi + slack;
      }
      const double nearest = std::min(range.nearest, truth.depth[i]),
                   farthest = std::max(range.farthest, truth.depth[i]);
      const bool depthFlips = farthest - nearest > depthSlack;
      const double slack = depthSlack + 0.01 * std::max(0.0, range.farthestHit - nearest);
      const bool depthAmong = mine.depth[i] >= nearest - slack && mine.depth[i] <= farthest + slack;
      colorWrong = d > options.tolerance && !(changes && among);
      depthWrong = depthDiffers && !hidden && !(depthFlips && depthAmong);
    }
    auto show = [&](const char* what) {
      worst << "  " << what << " (" << pixel.x << ", " << pixel.y << ")";
      for (int c = 0; c < 4; c++)
        worst << ' ' << a[c] << '|' << b[c] << " [" << range.lo[c] << ' ' << range.hi[c] << ']';
      worst << " depth " << mine.depth[i] << '|' << truth.depth[i] << " [" << range.nearest << ' '
            << range.farthest << "]\n";
    };
    if (colorWrong || depthWrong) {
      result.wrongDepths += depthWrong;
      if (colorWrong) result.largest = std::max(result.largest, d);
      result.wrong.push_back(pixel);
      if (result.wrong.size() <= 6) show(colorWrong ? "wrong" : "wrong depth");
      if (result.wrong.size() >= 400) {
        worst << "  ... and more\n";
        break;
      }
    } else {
      result.flips++;
      if (++flipsShown <= 3) show("flip");
    }
  }
  std::ostringstream out;
  out << scene.name << ": largest " << result.largest << ", seen " << result.seen << " of " << result.pixels
      << ", flips " << result.flips << ", wrong " << result.wrong.size() << " (depths " << result.wrongDepths
      << ")" << (result.finite ? "" : ", NOT FINITE") << '\n'
      << worst.str();
  if (!result.wrong.empty() || !result.finite || result.flips * 1000 > result.pixels) {
    writePictures(scene, mine, truth);
    out << "  pictures in " << testing::TempDir() << scene.name << "_*.png\n";
  }
  result.report = out.str();
  return result;
}

void expectAgreement(const Backend& backend, const TestScene& scene, const CompareOptions& options, int flips,
                     int seen) {
  const Comparison c = compare(backend, scene, options);
  EXPECT_TRUE(c.finite) << c.report;
  EXPECT_TRUE(c.wrong.empty()) << c.report;
  EXPECT_LE(c.flips, flips >= 0 ? flips : std::max(1, c.pixels / 1000)) << c.report;
  EXPECT_GE(c.seen, seen) << c.report;
  testing::Test::RecordProperty(scene.name, std::to_string(c.largest));
}

}  // namespace gxy::agreement
