// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>

#include "backends/vulkan/vulkan_device.h"
#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "shaders/layout.h"
#include "tests/support/frames.h"
#include "tools/gpu-report/report.h"

namespace gxy::gpu_report {

namespace {

using test::TestScene;

constexpr double kNodeBytes = 4 * NODE_WORDS;
constexpr double kSphereBytes = 4 * (2 + 4);  // an entry of the list of primitives; centre and radius

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A dense field of waves on [-1, 1]^3, n points an axis.
std::shared_ptr<const test::WholeVolume> waves(int64_t n) {
  auto whole = std::make_shared<test::WholeVolume>();
  whole->grid.points = {n, n, n};
  whole->grid.origin = glm::dvec3(-1);
  whole->grid.spacing = glm::dvec3(2.0 / double(n - 1));
  whole->samples.resize(size_t(n) * size_t(n) * size_t(n) * sizeof(float));
  auto* values = reinterpret_cast<float*>(whole->samples.data());
  std::vector<float> s(static_cast<size_t>(n));
  for (int64_t i = 0; i < n; i++) s[size_t(i)] = float(std::sin(25.0 * double(i) / double(n)));
  parallelFor(int64_t(0), n, [&](int64_t z) {
    for (int64_t y = 0; y < n; y++)
      for (int64_t x = 0; x < n; x++)
        values[(z * n + y) * n + x] =
            0.5f + 0.25f * (s[size_t(x)] * s[size_t(y)] + s[size_t(y)] * s[size_t(z)]);
  });
  return whole;
}

TestScene sceneOf(const std::string& name, int size) {
  TestScene scene = test::emptyScene(name, {size, size});
  scene.domain = {glm::dvec3(-1), glm::dvec3(1)};
  scene.camera = test::cameraOutside(scene.domain, {size, size});
  return scene;
}

void addVolume(TestScene& scene, std::shared_ptr<const test::WholeVolume> volume, bool rendered,
               bool isosurface) {
  Vis vis;
  vis.type = VisType::Volume;
  vis.volumeRendering = rendered;
  if (rendered) vis.opacitymap = {false, {{0, 0}, {0.3, 0.02}, {1, 0.3}}};
  if (isosurface) vis.isovalues = {0.7};
  scene.visualization.operators.push_back(vis);
  scene.data.emplace_back(std::move(volume));
}

void addSpheres(TestScene& scene, size_t count) {
  auto geometry = std::make_shared<test::WholeGeometry>();
  geometry->block.points.resize(count);
  uint64_t state = 1;
  const auto next = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return 2 * (double(state >> 11) * 0x1p-53) - 1;
  };
  for (glm::dvec3& p : geometry->block.points) {
    p.x = next(), p.y = next(), p.z = next();
  }
  geometry->block.ids.resize(count);
  for (size_t i = 0; i < count; i++) geometry->block.ids[i] = i;
  Vis vis;
  vis.type = VisType::Particles;
  vis.radius0 = vis.radius1 = 0.35 / std::cbrt(double(count));
  scene.visualization.operators.push_back(vis);
  scene.data.emplace_back(std::move(geometry));
}

std::string rounded(double x) {
  std::ostringstream out;
  out << std::setprecision(3) << x;
  return out.str();
}

/// A scene on a device, and frames of it one after another.
class Frames {
 public:
  Frames(const Backend& device, const TestScene& scene) : frames_(1, run()) {
    frames_.add(
        1, test::compiledOn(test::whole(scene.domain), scene, [&](int) -> const Backend& { return device; }));
    request_.scene = 1;
    request_.camera = scene.camera;
  }

  /// Seconds that one takes.
  double frame() {
    const double start = seconds();
    const FrameId id = frames_.start(request_);
    frames_.run();
    if (const std::string& error = frames_.outcome(id).error; !error.empty()) throw Error(error);
    return seconds() - start;
  }
  TraceCounters counters() { return frames_.renderer(0).counters().trace; }

 private:
  static test::FrameRun run() {
    test::FrameRun run;
    run.threaded = true;
    run.options.raysInFlight = int64_t(1) << 24;
    return run;
  }
  test::Frames frames_;
  FrameRequest request_;
};

/// Bytes of the nodes and spheres that the rays of a frame come to; not of a frame that is timed, as counting them takes time.
double hierarchyBytes(const VulkanOptions& options, const TestScene& scene) {
  VulkanOptions counting = options;
  counting.countsNodes = true;
  const std::unique_ptr<Backend> device = makeVulkanBackend(counting);
  Frames frames(*device, scene);
  frames.frame();
  const TraceCounters c = frames.counters();
  return kNodeBytes * double(c.nodes) + kSphereBytes * double(c.primitives);
}

/// Times frames one after another, at least one, for so long.
void measure(const VulkanOptions& options, const Backend& device, const TestScene& scene, double duration,
             double copyRate, Report& report) {
  const double begin = seconds();
  std::optional<Frames> frames(std::in_place, device, scene);
  const double making = seconds() - begin;
  const double first = frames->frame();  // compiles shaders
  frames->frame();
  const TraceCounters before = frames->counters();
  std::vector<double> times;
  for (const double until = seconds() + std::min(duration, report.left());
       times.empty() || (seconds() < until && times.size() < 50);)
    times.push_back(frames->frame());
  const TraceCounters after = frames->counters();
  frames.reset();  // the device has room for it again
  std::sort(times.begin(), times.end());
  const auto each = [&](auto TraceCounters::*field) {
    return double(after.*field - before.*field) / double(times.size());
  };
  const auto ms = [&](auto TraceCounters::*field) { return rounded(1e-6 * each(field)); };
  const bool spheres = scene.visualization.operators[0].type == VisType::Particles;
  const double busy = 1e-9 * each(&TraceCounters::nsDevice);
  const double asked =  // bytes a second
      (32 * (each(&TraceCounters::samples) + each(&TraceCounters::cells)) +
       (spheres ? hierarchyBytes(options, scene) : 0)) /
      busy;
  std::ostringstream line;
  line << "| " << scene.name << " | " << rounded(making) << " | " << rounded(first) << " | "
       << rounded(1e3 * times[0]) << " | " << rounded(1e3 * times[times.size() / 2]) << " | "
       << rounded(1e3 * busy) << " | " << ms(&TraceCounters::nsDeviceIdle) << " | "
       << rounded(each(&TraceCounters::submissions)) << " | " << ms(&TraceCounters::nsSpawn) << " | "
       << ms(&TraceCounters::nsGeometry) << " | " << ms(&TraceCounters::nsSurfaces) << " | "
       << ms(&TraceCounters::nsIntegrate) << " | " << ms(&TraceCounters::nsShade) << " | "
       << rounded(1e-6 * each(&TraceCounters::raysTraced) / busy) << " | "
       << rounded(1e-6 * each(&TraceCounters::samples) / busy) << " | " << rounded(1e-9 * asked) << " | "
       << rounded(100 * asked / copyRate) << " |";
  report.line(line.str());
}

/// Bytes that a device's copies within its own memory read and write in a second, measured with 256 MiB * scale, 4 MiB at least.
double copyRate(const VulkanOptions& options, double scale) {
  const vulkan::Device device(options);
  const auto bytes = std::max(size_t(4) << 20, size_t(double(size_t(256) << 20) * scale));
  const vulkan::Buffer from(device, bytes, vulkan::Place::Device, "copies"),
      to(device, bytes, vulkan::Place::Device, "copies");
  vulkan::Commands commands(device);
  double best = 1e30;
  for (int turn = 0; turn < 5; turn++) {
    constexpr int kCopies = 10;
    const VkCommandBuffer c = commands.begin();
    const VkBufferCopy region{0, 0, bytes};
    for (int i = 0; i < kCopies; i++) {
      vkCmdCopyBuffer(c, from.get(), to.get(), 1, &region);
      commands.barrier();
    }
    const double start = seconds();
    commands.submit();
    commands.wait();
    best = std::min(best, (seconds() - start) / kCopies);
  }
  return 2 * double(bytes) / best;
}

}  // namespace

Tally benchmarks(const Backend& device, const VulkanOptions& options, double scale, double seconds,
                 Report& report) {
  const auto n = std::max<int64_t>(32, std::llround(512 * scale));
  const int size = std::max(128, int(std::lround(1024 * std::sqrt(scale))));
  const auto spheres = size_t(std::llround(1e7 * scale * scale * scale));
  report.line(
      "\n## Times\n\n"
      "One rank; a frame's time is from its request to its picture, the other milliseconds are the device's "
      "own clock, of a frame. Idle: the device had nothing to do before the frame's last work. GB/s: the 8 "
      "samples that each evaluation and each cell of an isosurface asks for, and the nodes (112 bytes) and "
      "spheres (24) that rays come to, caches included; and as a part of what the device's own copies read "
      "and write: near 100 % its memory limits, far below its arithmetic, or how long it waits for what it "
      "asks for.\n");
  double copied = std::numeric_limits<double>::quiet_NaN();
  try {
    if (report.left() > 0) copied = copyRate(options, scale);
    report.line("Copies of the device: " + rounded(1e-9 * copied) + " GB/s.\n");
  } catch (const std::exception& e) {
    report.line(std::string("Copies of the device: ") + e.what() + "\n");
  }
  report.line(
      "| scene | load, s | first frame, s | best, ms | median, ms | busy | idle | submissions | spawn | "
      "geometry | surfaces "
      "| march | shade | Mrays/s | Msamples/s | GB/s | % of copies |");
  report.line("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
  const std::string cube = std::to_string(n) + "^3", at = " at " + std::to_string(size) + "^2";
  std::shared_ptr<const test::WholeVolume> volume;
  const auto field = [&] { return volume ? volume : volume = waves(n); };
  const std::pair<std::string, std::function<void(TestScene&)>> kinds[] = {
      {"volume " + cube + at, [&](TestScene& s) { addVolume(s, field(), true, false); }},
      {"isosurface " + cube + at, [&](TestScene& s) { addVolume(s, field(), false, true); }},
      {std::to_string(spheres) + " spheres, 4 occlusion rays" + at,
       [&](TestScene& s) { addSpheres(s, std::max<size_t>(spheres, 1000)), test::addOcclusion(s); }},
      {"volume, isosurface, shadows, 4 occlusion rays" + at, [&](TestScene& s) {
         addVolume(s, field(), true, true), test::addOcclusion(s);
         s.visualization.lighting.shadows = true;
       }}};
  Tally tally;
  for (const auto& [name, fill] : kinds) {
    tally.all++;
    if (report.left() < 0) {
      report.line("| " + name + " | left out: no time |");
      continue;
    }
    tally.tried++;
    try {
      TestScene scene = sceneOf(name, size);
      fill(scene);
      measure(options, device, scene, seconds, copied, report);
    } catch (const std::exception& e) {
      tally.failed++;
      report.line("| " + name + " | " + e.what() + " |");
    }
  }
  return tally;
}

}  // namespace gxy::gpu_report
