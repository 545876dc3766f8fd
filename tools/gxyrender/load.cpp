// SPDX-License-Identifier: Apache-2.0
#include "load.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "gxy/comm/error.h"
#include "gxy/data/replicate.h"
#include "gxy/io/import_geometry.h"
#include "gxy/io/import_volume.h"

namespace gxy {

namespace {

GeometryKind kindOf(DatasetType type) {
  if (type == DatasetType::Particles) return GeometryKind::Particles;
  return type == DatasetType::PathLines ? GeometryKind::PathLines : GeometryKind::Triangles;
}

// A partition's samples stay below 2^31 bytes up to 7 bytes a point: beyond, kernels need 64-bit offsets and more time.
constexpr int64_t kMostPoints = int64_t(1) << 28;

std::shared_ptr<const Partitioning> makePartitioning(const Box& domain, const Grid* grid,
                                                     std::array<int, 3> wanted, int ranks) {
  // The grid whose points carry the cuts: that of the first volume if it fills the domain, else a fine lattice.
  const bool onGrid = grid && grid->box() == domain;
  const glm::dvec3 size = domain.hi - domain.lo;
  const double longest = std::max({size.x, size.y, size.z});
  Index3 cells{};
  for (int a = 0; a < 3; a++)
    cells[a] =
        onGrid ? grid->cells()[a] : std::max<int64_t>(1, int64_t(std::ceil(1048576 * size[a] / longest)));
  if (wanted[0] == 0) {
    const Index3 points = grid ? grid->points : Index3{1, 1, 1};
    wanted[0] = int(std::max<int64_t>(ranks, points[0] * points[1] * points[2] / kMostPoints + 1));
  }
  if (wanted[1] == 0) wanted = decompose(wanted[0], cells);
  std::array<std::vector<double>, 3> faces;
  for (int a = 0; a < 3; a++)
    faces[a] = evenFaces(domain.lo[a], domain.hi[a], wanted[a], onGrid ? cells[a] : 0);
  return std::make_shared<Partitioning>(Partitioning::lattice(faces, ranks));
}

// Gives a flat domain some thickness: a partitioning needs a volume.
Box thickened(Box box) {
  if (box.empty()) return {glm::dvec3(-1), glm::dvec3(1)};
  const glm::dvec3 size = box.hi - box.lo;
  const double longest = std::max({size.x, size.y, size.z});
  const double least = longest > 0 ? 1e-3 * longest : 1e-3 * std::max(1.0, std::abs(box.lo.x));
  for (int a = 0; a < 3; a++)
    if (size[a] < least) box.lo[a] -= 0.5 * least, box.hi[a] += 0.5 * least;
  return box;
}

}  // namespace

LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger) {
  std::map<std::string, const DatasetSpec*> specs;
  for (const DatasetSpec& d : state.datasets) specs[d.name] = &d;
  std::set<std::string> shown;
  for (const Visualization& v : state.visualizations)
    for (const Vis& op : v.operators) {
      if (!specs.count(op.dataset))
        throw Error("an operator shows dataset \"" + op.dataset + "\", which the state file does not define");
      shown.insert(op.dataset);
    }
  auto pathOf = [&](const DatasetSpec& d) {
    const std::filesystem::path p(d.filename);
    return p.is_absolute() ? p.string() : (std::filesystem::path(directory) / p).string();
  };

  // What is where, before anything is cut: grids, and geometry as each rank has read it.
  Box domain;
  std::optional<Grid> first;
  std::map<std::string, LoadedGeometry> geometry;
  for (const DatasetSpec& d : state.datasets) {
    if (!shown.count(d.name)) continue;
    if (d.type == DatasetType::Volume) {
      const Grid grid = gridOf(pathOf(d), d.array, ranks);
      domain.extend(grid.box());
      if (!first) first = grid;
    } else {
      const LoadedGeometry& g =
          geometry.emplace(d.name, loadGeometry(pathOf(d), kindOf(d.type), d.array, ranks)).first->second;
      domain.extend(g.box);
    }
  }

  LoadedState loaded;
  loaded.partitioning =
      makePartitioning(thickened(domain), first ? &*first : nullptr, options.partitions, ranks.size());
  std::map<std::string, std::shared_ptr<const Volume>> volumes;
  for (const DatasetSpec& d : state.datasets)
    if (shown.count(d.name) && d.type == DatasetType::Volume) {
      auto volume = importVolume(pathOf(d), d.array, *loaded.partitioning, kGhostLayers, ranks);
      loaded.memory.push_back(ledger.enter(kTenant, "volume", bytesOf(*volume)));
      volumes[d.name] = std::move(volume);
    }

  // Geometry goes to every partition that it touches with the radius that its Vis gives it.
  for (const Visualization& v : state.visualizations) {
    auto& list = loaded.data.emplace_back();
    for (const Vis& op : v.operators) {
      const DatasetSpec& d = *specs[op.dataset];
      OperatorData& data = list.emplace_back();
      data.color = glm::dvec3(d.color);
      if (d.type == DatasetType::Volume) {
        data.volume = volumes[d.name];
      } else {
        auto g = distribute(
            geometry.at(d.name), *loaded.partitioning,
            [&](double value) { return op.type == VisType::Triangles ? 0.0 : radiusOf(op, value); }, ranks);
        loaded.memory.push_back(ledger.enter(kTenant, "geometry", bytesOf(*g)));
        data.geometry = std::move(g);
      }
    }
  }
  return loaded;
}

std::shared_ptr<const CompiledScene> makeScene(const State& state, const LoadedState& loaded, size_t v,
                                               Collectives& ranks) {
  std::shared_ptr<CompiledScene> scene;
  agree(ranks, [&] {
    scene = compileScene(state.visualizations[v], loaded.data[v], loaded.partitioning, state.settings);
  });
  Bytes mine(scene->visible.size());
  std::transform(scene->visible.begin(), scene->visible.end(), mine.begin(),
                 [](uint8_t x) { return std::byte(x); });
  for (const Bytes& theirs : ranks.allGather(std::move(mine)))
    for (size_t p = 0; p < theirs.size(); p++) scene->visible[p] |= uint8_t(theirs[p]);
  return scene;
}

}  // namespace gxy
