// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/page.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <thread>

#include "core/comm/error.h"
#include "core/scene/scene.h"
#include "tools/gxybench/chart.h"
#include "tools/gxybench/scenes.h"

namespace gxy::bench {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

/// The processor's name as the system reports it.
std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

Chart chartOf(const std::string& scene, const std::vector<Row>& rows, double Row::*error,
              const std::string& label) {
  Chart chart;
  chart.title = scene, chart.xLabel = "CPU seconds per frame", chart.yLabel = label;
  for (const Row& r : rows) {
    if (r.scene != scene) continue;
    auto curve = std::find_if(chart.curves.begin(), chart.curves.end(),
                              [&](const Curve& c) { return c.name == r.curve(); });
    if (curve == chart.curves.end()) curve = chart.curves.insert(curve, {r.curve(), {}, {}});
    curve->x.push_back(r.cpu);
    curve->y.push_back(r.*error);
  }
  return chart;
}

std::string cells(const Row& r) {
  std::ostringstream out;
  out.precision(4);
  out << "<tr><td>" << r.curve() << "<td>" << r.setting << "<td>" << 1e3 * r.wall << "<td>"
      << 1e3 * r.wallSpread << "<td>" << 1e3 * r.cpu << "<td>" << 1e3 * r.cpuSpread << "<td>"
      << 1e-6 * double(r.samples) << "<td>" << 1e-6 * double(r.cells) << "<td>" << 1e-6 * double(r.rays)
      << "<td>" << 1e-6 * double(r.bytesSent) << "<td>" << 1e-6 * double(r.peakMemory) << "<td>" << r.maxError
      << "<td>" << r.rmsError << "<td>" << r.p999Error << "<td>" << r.flips;
  if (r.hits >= 0)
    out << "<td>" << r.hits << "<td>" << r.missed << "<td>" << r.extra << "<td>" << r.wrongSheet << "<td>"
        << r.dtRms << "<td>" << r.dtMax;
  return out.str() + "\n";
}

constexpr const char* kHead = R"(<!doctype html>
<meta charset="utf-8">
<title>gxybench</title>
<style>
body { font: 15px sans-serif; max-width: 1280px; margin: 1em auto; padding: 0 1em; }
img { max-width: 49%; } table { border-collapse: collapse; font-size: 12px; }
td, th { padding: 1px 7px; text-align: right; border-bottom: 1px solid #ddd; }
td:first-child { text-align: left; }
</style>
<h1>Run time against error</h1>
)";

}  // namespace

void writeCharts(const std::string& folder, const std::string& scene, const std::vector<Row>& rows) {
  Chart largest = chartOf(scene, rows, &Row::maxError, "largest error");
  largest.line = RenderSettings().tolerance;
  largest.lineName = "tolerance " + fractionText(largest.line);
  writeChart(folder + "/" + scene + "-max.svg", largest);
  writeChart(folder + "/" + scene + "-rms.svg", chartOf(scene, rows, &Row::rmsError, "RMS error"));
}

void writePage(const std::string& folder, const std::vector<Heading>& scenes, const std::vector<Row>& rows,
               const std::string& command) {
  const std::string path = folder + "/index.html";
  std::ofstream out(path);
  out << kHead << "<p>" << escaped(processor()) << ", " << std::thread::hardware_concurrency()
      << " threads. <code>" << escaped(command) << "</code>, <a href=results.csv>results.csv</a>\n";
  for (const Heading& scene : scenes) {
    const auto ofScene = [&](const Row& r) { return r.scene == scene.name; };
    const auto first = std::find_if(rows.begin(), rows.end(), ofScene);
    if (first == rows.end()) continue;
    out << "<h2 id=\"" << escaped(scene.name) << "\">" << escaped(scene.name) << "</h2>\n<p>"
        << escaped(scene.about) << ", " << first->width << " x " << first->height << " pixels\n<p>";
    for (const char* kind : {"max", "rms"})
      out << "<img src=\"" << escaped(scene.name) << "-" << kind << ".svg\" alt=\"" << kind
          << " error against time\">";
    out << "\n<details><summary>numbers</summary><table>\n<tr><th>curve<th>setting<th>wall "
           "ms<th>spread<th>CPU ms<th>spread"
           "<th>M samples<th>M cells<th>M rays<th>MB sent<th>peak MB<th>max error<th>RMS<th>99.9 %<th>flips";
    if (first->hits >= 0) out << "<th>hits<th>missed<th>extra<th>wrong sheet<th>dt RMS, cells<th>dt max";
    out << '\n';
    for (const Row& r : rows)
      if (ofScene(r)) out << cells(r);
    out << "</table></details>\n";
  }
  if (!out.flush()) throw Error(path + ": cannot be written");
}

}  // namespace gxy::bench
