// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <iomanip>
#include <span>
#include <sstream>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"
#include "tests/support/close_pictures.h"
#include "tests/support/frames.h"
#include "tools/gpu-report/report.h"

namespace gxy::gpu_report {

namespace {

std::string percent(size_t part, size_t all) {
  std::ostringstream out;
  out << std::setprecision(6) << (all ? 100.0 * double(part) / double(all) : 100.0);
  return out.str();
}

void writeRaw(const std::string& file, const Picture& picture) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(picture.rgba.data()),
            std::streamsize(picture.rgba.size() * sizeof(float)));
  if (!out.flush()) throw Error(file + ": cannot be written");
}

bool sameBits(const Picture& a, const Picture& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::ranges::equal(std::as_bytes(std::span(x)), std::as_bytes(std::span(y)));
  };
  return same(a.rgba, b.rgba) && same(a.depth, b.depth);
}

}  // namespace

Tally agreement(const Backend& device, int most, const std::string& folder, Report& report) {
  report.line("\n## Agreement with the Embree backend (" + makeEmbreeBackend()->device() + ")\n");
  report.line(
      "| scene | pixels | equal to the bit, % | farther than 1/255 | largest difference | hits within 4 ulp, "
      "% "
      "| in pieces | |");
  report.line("|---|---|---|---|---|---|---|---|");
  std::vector<test::TestScene> scenes = test::scenesOfEachKind();
  scenes.push_back(test::everything({192, 160}));
  Tally tally{.all = int(scenes.size())};
  const double untilThen = 0.5 * report.left();  // the rest is for the benchmarks
  for (test::TestScene& scene : scenes) {
    if (tally.tried == most || report.left() < untilThen) {
      report.line("| " + scene.name + " | left out" + (tally.tried == most ? " |" : ": no time |"));
      continue;
    }
    tally.tried++;
    scene.camera.dimensions = {192, 160};
    const auto onDevice = [&](int) -> const Backend& { return device; };
    const test::Cut one = test::whole(scene.domain), many = test::kdCut(scene.domain, 6, 3, 5);
    std::string verdict = "agrees", pieces = "not tried";
    test::Closeness d;
    try {
      const Picture expected = test::render(scene, one);
      const Picture mine = test::render(scene, 1, test::compiledOn(one, scene, onDevice));
      if (!folder.empty()) {
        writeRaw(folder + "/" + scene.name + ".embree.raw", expected);
        writeRaw(folder + "/" + scene.name + ".device.raw", mine);
      }
      d = test::closenessOf(expected, mine);
      const Picture cut = test::render(scene, many.ranks, test::compiledOn(many, scene, onDevice));
      pieces = sameBits(mine, cut) ? "the same" : "DIFFERENT";
      if (!d.agrees() || pieces != "the same") verdict = "FAILS";
    } catch (const std::exception& e) {
      verdict = std::string("FAILS: ") + e.what();
    }
    tally.failed += verdict != "agrees";
    std::ostringstream line;
    line << "| " << scene.name << " | " << d.pixels << " | " << percent(d.equal, d.pixels) << " | " << d.far
         << " | " << std::setprecision(3) << d.largest << " | " << percent(d.hits - d.hitsFar, d.hits)
         << " | " << pieces << " | " << verdict << " |";
    report.line(line.str());
  }
  return tally;
}

}  // namespace gxy::gpu_report
