// SPDX-License-Identifier: Apache-2.0
// loading_benchmark read|import FILE THREADS: reads a file (.vti: a volume; .vtp and .vtu: points), or imports it on one
// rank, with so many threads, and prints how long it took: wall seconds, processor seconds, and the most memory in MB. An import
// also makes what scenes need: ranges, boxes, bricks and summaries. loading_benchmark.py compares that with VTK's readers.
#include <sys/resource.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/io/geometry_file.h"
#include "core/io/import_geometry.h"
#include "core/io/import_volume.h"

namespace {

using namespace gxy;

void load(const std::string& path, bool import) {
  SingleRank alone;
  if (isVolumeFile(path)) {
    const VolumeFile file = openVolume(path);
    if (import) {
      importVolume(file, Partitioning::single(file.grid.box()), 1, alone);
    } else {
      std::vector<std::byte> samples(size_t(wholeOf(file.grid).count()) * file.bytesPerPoint());
      readVolume(file, wholeOf(file.grid), samples);
    }
  } else {
    // All arrays of a .vtu are read for either kind. To find the surface of its cells is no reading.
    const bool cells = path.ends_with(".vtu");
    import ? void(loadGeometry(path, cells ? GeometryKind::Triangles : GeometryKind::Particles, {}, alone))
           : void(readGeometry(path, GeometryKind::Particles));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("usage: loading_benchmark read|import FILE THREADS\n", stderr), 2;
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    std::strtoull(argv[3], nullptr, 10));
  try {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    load(argv[2], argv[1] == std::string("import"));
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf("%.3f %.3f %.0f\n", wall, double(std::clock() - cpu) / CLOCKS_PER_SEC,
                double(usage.ru_maxrss) * 1024 / 1e6);
  } catch (const std::exception& e) {
    return std::fprintf(stderr, "loading_benchmark: %s\n", e.what()), 1;
  }
}
