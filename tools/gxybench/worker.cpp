// SPDX-License-Identifier: Apache-2.0
// The workers: they load once, then compile and render each setting.
#include "tools/gxybench/worker.h"

#include <algorithm>
#include <condition_variable>
#include <fstream>
#include <iostream>
#include <mutex>
#include <optional>
#include <span>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "core/comm/mpi_environment.h"
#include "core/comm/mpi_transport.h"
#include "core/render/renderer.h"
#include "tools/gxybench/job.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/statistics.h"

namespace gxy::bench {
namespace {

constexpr uint64_t kRunKey = 1;  // key of this run's collectives
constexpr int kMostRepeats = 25;

template <class T>
void writeTo(const std::string& path, std::span<const T> values) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size_bytes()));
  if (!out.flush()) throw Error(path + ": cannot be written");
}

/// Resets the process's peak memory, if the system allows it.
void forgetPeakMemory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return 0.5 * (v[(v.size() - 1) / 2] + v[v.size() / 2]);
}
double spread(const std::vector<double>& v) {
  const auto [low, high] = std::minmax_element(v.begin(), v.end());
  return *high - *low;
}

Bytes bytesOf(const std::string& s) {
  const auto* p = reinterpret_cast<const std::byte*>(s.data());
  return Bytes(p, p + s.size());
}
nlohmann::json jsonOf(const Bytes& b) {
  return nlohmann::json::parse(std::string(reinterpret_cast<const char*>(b.data()), b.size()));
}

/// The counters of a rank that are reported, since its start.
nlohmann::json countersOf(const Renderer& renderer) {
  const Renderer::Counters c = renderer.counters();
  return {{"samples", c.trace.samples},
          {"macrocells", c.trace.macrocells},
          {"cells", c.trace.cells},
          {"rays", c.trace.raysSpawned + c.trace.secondariesSpawned},
          {"bytes_sent", c.rayBytes + c.contributionBytes}};
}

class Worker {
 public:
  Worker(MpiTransport& transport, const Job& job)
      : transport_(transport),
        job_(job),
        collective_(transport),
        ranks_(collective_, transport.rank(), transport.size(), kRunKey),
        renderer_(transport, {}) {}

  void run() {
    const BackendRegistry registry = allBackends({job_.device, transport_.rankOnNode()});
    agree(ranks_, [&] { backend_ = registry.make(job_.backend, &ledger_); });
    loaded_ = loadData(job_.settings.at(0).state, job_.directory, {}, ranks_, ledger_);
    for (size_t i = 0; i < job_.settings.size(); i++) runSetting(i);
    renderer_.onPicture({});
    collective_.barrier(kRunKey);
  }

 private:
  struct Times {
    double wall, cpu;
  };

  void runSetting(size_t i) {
    forgetPeakMemory();
    const State& state = job_.settings[i].state;
    SceneBuilder builder(*backend_, transport_.rank());
    const EnterMemory enter = [this](const char* purpose, int64_t bytes) {
      return ledger_.enter("bench", purpose, bytes);
    };
    const BuiltScene scene = builder.build(sceneSource(state, loaded_, 0, ranks_), ranks_, enter);
    renderer_.addScene(i, scene.compiled, scene.device);
    collective_.barrier(kRunKey);

    // The first frame warms up. Its picture is the one that is compared.
    std::optional<std::string> error;
    renderer_.onPicture([&](FrameId, const FrameRequest&, Picture picture) {
      try {
        writeTo(pictureFile(job_, i) + ".raw", std::span<const float>(picture.rgba));
        writeTo(pictureFile(job_, i) + ".depth", std::span<const double>(picture.depth));
      } catch (const Error& e) {
        error = e.what();
      }
    });
    frame(i, loaded_.camera(picturesOf(state).at(0)), true);
    renderer_.onPicture({});
    collective_.agree(kRunKey, error);

    const nlohmann::json before = countersOf(renderer_);
    std::vector<double> wall, cpu;
    double total = 0;
    while (int(wall.size()) < job_.repeats || (total < job_.seconds && int(wall.size()) < kMostRepeats)) {
      const Times t = frame(i, loaded_.camera(picturesOf(state).at(0)), false);
      wall.push_back(t.wall), cpu.push_back(t.cpu);
      total += t.wall;
    }
    report(i, before, wall, cpu);
    renderer_.removeScene(i);
  }

  /// Renders one frame. Returns rank 0's time and the processor time of all ranks; the same numbers on all
  /// ranks.
  Times frame(SceneId scene, const Camera& camera, bool depth) {
    collective_.barrier(kRunKey);
    const double cpu = cpuSeconds(), wall = wallSeconds();
    double elapsed = 0;
    if (transport_.rank() == 0) {
      std::mutex mutex;
      std::condition_variable changed;
      bool done = false;
      FrameRequest request;
      request.scene = scene;
      request.camera = camera;
      request.depth = depth;
      renderer_.render(request, [&](FrameId, const Renderer::Ending&) {
        std::lock_guard lock(mutex);
        done = true;
        changed.notify_all();
      });
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return done; });
      elapsed = wallSeconds() - wall;
    }
    collective_.barrier(kRunKey);
    const nlohmann::json mine{elapsed, cpuSeconds() - cpu};
    Times times{0, 0};
    for (const Bytes& b : ranks_.allGather(bytesOf(mine.dump()))) {
      const nlohmann::json theirs = jsonOf(b);
      times.wall += theirs[0].get<double>();
      times.cpu += theirs[1].get<double>();
    }
    return times;
  }

  void report(size_t i, const nlohmann::json& before, const std::vector<double>& wall,
              const std::vector<double>& cpu) {
    nlohmann::json mine = countersOf(renderer_);
    for (auto& [name, value] : mine.items())
      value = (value.get<int64_t>() - before.at(name).get<int64_t>()) / int64_t(wall.size());
    mine["bytes_held"] = ledger_.total();
    const int64_t peak = processBytes().peakResident;
    int64_t largest = 0;
    nlohmann::json sum = nlohmann::json::object();
    for (const Bytes& b : ranks_.allGather(bytesOf(nlohmann::json{mine, peak}.dump()))) {
      const nlohmann::json theirs = jsonOf(b);
      for (const auto& [name, value] : theirs[0].items())
        sum[name] = sum.value(name, int64_t(0)) + value.get<int64_t>();
      largest = std::max(largest, theirs[1].get<int64_t>());
    }
    if (transport_.rank() != 0) return;
    const Setting& setting = job_.settings[i];
    const glm::ivec2 size = setting.state.cameras[0].dimensions;
    Row row;
    row.method = setting.method, row.setting = setting.label, row.backend = backend_->name();
    row.ranks = transport_.size(), row.threads = transport_.threads();
    row.width = size.x, row.height = size.y;
    row.tolerance = setting.state.settings.tolerance;
    row.repeats = int64_t(wall.size());
    row.wall = median(wall), row.wallSpread = spread(wall);
    row.cpu = median(cpu), row.cpuSpread = spread(cpu);
    row.samples = sum.at("samples"), row.macrocells = sum.at("macrocells"), row.cells = sum.at("cells");
    row.rays = sum.at("rays"), row.bytesSent = sum.at("bytes_sent"), row.bytesHeld = sum.at("bytes_held");
    row.peakMemory = largest;
    std::cout << kLineMark + nlohmann::json{{"setting index", i}, {"row", toJson(row)}}.dump() + "\n"
              << std::flush;
  }

  MpiTransport& transport_;
  const Job& job_;
  Ledger ledger_;
  Collective collective_;
  RankCollectives ranks_;
  Renderer renderer_;
  std::unique_ptr<Backend> backend_;
  LoadedState loaded_;
};

}  // namespace

int work(const std::string& jobFile) {
  MpiEnvironment mpi;
  std::ifstream in(jobFile);
  if (!in) throw Error(jobFile + ": cannot be read; `gxybench work` is what gxybench itself starts");
  const Job job = jobOf(nlohmann::json::parse(in));
  MpiTransport::Options options;
  options.threads = job.threads;
  MpiTransport transport(options);
  try {
    Worker(transport, job).run();
  } catch (const Error& e) {
    if (transport.rank() == 0) std::cerr << "gxybench: error: " << e.what() << '\n';
    return 1;
  }
  return 0;
}

}  // namespace gxy::bench
