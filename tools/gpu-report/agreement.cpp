// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <sstream>

#include "gxy/embree/embree_backend.h"
#include "report.h"
#include "support/frames.h"

namespace gxy::gpu_report {

namespace {

struct Difference {
  size_t pixels = 0, equal = 0, far = 0;  ///< far: some channel by more than 1/255
  size_t depths = 0, depthsFar = 0;       ///< of surfaces that both see; by more than 4 ulp of a float
  double largest = 0;
};

Difference differenceOf(const Picture& a, const Picture& b) {
  Difference d;
  d.pixels = a.depth.size();
  for (size_t p = 0; p < d.pixels; p++) {
    double most = 0;
    for (size_t k = 4 * p; k < 4 * p + 4; k++) {
      const double here = std::abs(double(a.rgba[k]) - double(b.rgba[k]));
      most = std::isfinite(here) ? std::max(most, here) : 1e30;
    }
    const bool same = std::memcmp(&a.rgba[4 * p], &b.rgba[4 * p], 4 * sizeof(float)) == 0;
    d.equal += same && a.depth[p] == b.depth[p];
    d.far += most > 1.0 / 255;
    d.largest = std::max(d.largest, most);
    if (a.depth[p] >= 1e30 || b.depth[p] >= 1e30) continue;
    d.depths++;
    d.depthsFar += std::abs(a.depth[p] - b.depth[p]) > 4 * 0x1p-23 * std::abs(a.depth[p]);
  }
  return d;
}

std::string percent(size_t part, size_t all) {
  std::ostringstream out;
  out << std::setprecision(6) << (all ? 100.0 * double(part) / double(all) : 100.0);
  return out.str();
}

}  // namespace

Tally agreement(const Backend& device, Report& report) {
  report.line("\n## Agreement with the Embree backend (" + makeEmbreeBackend()->device() + ")\n");
  report.line(
      "| scene | pixels | equal to the bit, % | farther than 1/255 | largest difference | depths within 4 "
      "ulp, % "
      "| in pieces | |");
  report.line("|---|---|---|---|---|---|---|---|");
  std::vector<test::TestScene> scenes = test::scenesOfEachKind();
  scenes.push_back(test::everything({192, 160}));
  Tally tally{.all = int(scenes.size())};
  const double untilThen = 0.5 * report.left();  // the rest is for the benchmarks
  for (test::TestScene& scene : scenes) {
    if (report.left() < untilThen) {
      report.line("| " + scene.name + " | left out: no time |");
      continue;
    }
    tally.tried++;
    scene.camera.dimensions = {192, 160};
    const auto onDevice = [&](int) -> const Backend& { return device; };
    const test::Cut one = test::whole(scene.domain), many = test::kdCut(scene.domain, 6, 3, 5);
    std::string verdict = "agrees", pieces = "not tried";
    Difference d;
    try {
      const Picture expected = test::render(scene, one);
      const Picture mine = test::render(scene, 1, test::compiledOn(one, scene, onDevice));
      d = differenceOf(expected, mine);
      const Picture cut = test::render(scene, many.ranks, test::compiledOn(many, scene, onDevice));
      pieces = test::difference(mine, cut).empty() ? "the same" : "DIFFERENT";
      if (1000 * d.far > d.pixels || 1000 * d.depthsFar > std::max<size_t>(d.depths, 1000) ||
          pieces != "the same")
        verdict = "FAILS";
    } catch (const std::exception& e) {
      verdict = std::string("FAILS: ") + e.what();
    }
    tally.failed += verdict != "agrees";
    std::ostringstream line;
    line << "| " << scene.name << " | " << d.pixels << " | " << percent(d.equal, d.pixels) << " | " << d.far
         << " | " << std::setprecision(3) << d.largest << " | " << percent(d.depths - d.depthsFar, d.depths)
         << " | " << pieces << " | " << verdict << " |";
    report.line(line.str());
  }
  return tally;
}

}  // namespace gxy::gpu_report
