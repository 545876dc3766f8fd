// SPDX-License-Identifier: Apache-2.0
// A simulation of several ranks on one thread that publishes cells of all types with a volume, and the file that has the same.
#pragma once
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/comm/random.h"
#include "core/data/mesh_kinds.h"
#include "insitu/api/galaxy_insitu.h"
#include "tests/support/mesh_files.h"
#include "tests/support/mixed_meshes.h"

namespace gxy::test {

/// What one rank has in one step.
struct RankVolume {
  std::vector<std::array<double, 3>> points;
  std::vector<uint8_t> types;
  std::vector<int64_t> offsets{0}, connectivity;
  std::vector<double> heat;                ///< by point
  std::vector<std::array<float, 3>> flow;  ///< by point
  std::vector<int16_t> level;              ///< by point
};

/// The unit cube, cut into cells of all types, which ranks have shares of. Its points move a little when `moved` says so.
class MiniVolume {
 public:
  struct Settings {
    std::string name = "sea";
    int ranks = 2;
    uint32_t cubes = 3;   ///< by axis
    bool differ = false;  ///< points that ranks have in common have a value of its own on each
    uint64_t seed = 1;
  };
  MiniVolume(const std::string& options, const Settings& settings) : settings_(settings) {
    for (int r = 0; r < settings.ranks; r++)
      sims_.push_back(gxy_open(settings.name.c_str(), r, settings.ranks, options.c_str()));
  }
  ~MiniVolume() {
    for (gxy_sim* s : sims_) gxy_close(s, 0);
  }
  MiniVolume(const MiniVolume&) = delete;
  MiniVolume& operator=(const MiniVolume&) = delete;

  /// How far points inside the cube move, of the side of a cell; in each step that is published from now on.
  double moved = 0;
  /// Called with what all ranks have, before it is told.
  std::function<void(std::vector<RankVolume>& ranks)> change = [](auto&) {};

  int64_t step() const { return step_; }
  int64_t published() {
    gxy_stat statistics{};
    gxy_statistics(sims_[0], &statistics);
    return statistics.published;
  }
  void publish() {
    tellAll();
    for (gxy_sim* sim : sims_)
      EXPECT_NE(gxy_publish(sim, step_, 0.5 * double(step_)), GXY_WRONG) << gxy_message(sim);
  }
  void publishLastAndClose(double seconds) {
    tellAll();
    for (gxy_sim* sim : sims_)
      EXPECT_NE(gxy_publish_last(sim, step_, 0.5 * double(step_)), GXY_WRONG) << gxy_message(sim);
    std::vector<std::thread> threads;
    for (gxy_sim* s : sims_) threads.emplace_back([s, seconds] { gxy_close(s, seconds); });
    for (std::thread& t : threads) t.join();
    sims_.clear();
  }

  /// A file with what all ranks have had in a step, those of lower ranks first.
  GridFile fileOf(int64_t step) const {
    GridFile file;
    file.pointArrays = {{"heat", "Float64", 1, {}}, {"flow", "Float32", 3, {}}, {"level", "Int16", 1, {}}};
    for (const RankVolume& m : steps_.at(step)) {
      const auto first = uint32_t(file.points.size());
      for (const auto& p : m.points) file.points.emplace_back(p[0], p[1], p[2]);
      for (size_t c = 0; c < m.types.size(); c++) {
        auto& corners = file.cells.emplace_back(int(m.types[c]), std::vector<uint32_t>()).second;
        for (int64_t i = m.offsets[c]; i < m.offsets[c + 1]; i++)
          corners.push_back(first + uint32_t(m.connectivity[size_t(i)]));
      }
      for (const double v : m.heat) file.pointArrays[0].values.push_back(v);
      for (const auto& v : m.flow)
        for (const float c : v) file.pointArrays[1].values.push_back(double(c));
      for (const int16_t v : m.level) file.pointArrays[2].values.push_back(v);
    }
    return file;
  }

 private:
  // Shares are runs of cells, so that neighbouring ranks have points in common. The first rank has none of four.
  std::vector<RankVolume> shares() {
    Random moves(settings_.seed + 1);
    const double far = moved / double(settings_.cubes);
    const MeshPiece mesh = cubeOfAllCells(
        settings_.cubes,
        [&](const glm::dvec3& p) {
          glm::dvec3 by(0);
          for (int a = 0; a < 3; a++) {
            const double drawn = double(moves.below(1 << 20)) / (1 << 20) - 0.5;
            if (p[a] > 0 && p[a] < 1) by[a] = far * drawn;
          }
          return by;
        },
        [](const glm::dvec3&) { return 0; });
    std::vector<RankVolume> ranks(static_cast<size_t>(settings_.ranks));
    const size_t sharing = ranks.size() < 4 ? ranks.size() : ranks.size() - 1, n = mesh.cells.size();
    for (size_t r = 0; r < sharing; r++)
      take(mesh, n * r / sharing, n * (r + 1) / sharing, ranks[r + ranks.size() - sharing]);
    return ranks;
  }

  void take(const MeshPiece& mesh, size_t begin, size_t end, RankVolume& to) {
    constexpr std::array<uint8_t, kCellTypes> kTypes{GXY_TETRAHEDRON, GXY_PYRAMID, GXY_WEDGE, GXY_HEXAHEDRON};
    std::map<uint32_t, int64_t> numbers;
    to.points.push_back({0.5, 0.5, 0.5});  // a point that no cell has
    for (size_t c = begin; c < end; c++) {
      const auto cell = mesh.cells.pointsOf(uint32_t(c));
      uint8_t type = kTypes[size_t(mesh.cells.typeOf(uint32_t(c)))];
      if (type == GXY_HEXAHEDRON && c % 2 == 0) type = GXY_VOXEL;
      to.types.push_back(type);
      const size_t first = to.connectivity.size();
      to.connectivity.resize(first + cell.size());
      for (size_t i = 0; i < cell.size(); i++) {
        const auto [known, isNew] = numbers.try_emplace(cell[i], int64_t(to.points.size()));
        const glm::dvec3& p = mesh.points[cell[i]];
        if (isNew) to.points.push_back({p.x, p.y, p.z});
        to.connectivity[first + placeInFile(type, i)] = known->second;
      }
      to.offsets.push_back(int64_t(to.connectivity.size()));
    }
    for (const auto& p : to.points) {
      const double own = settings_.differ ? double(begin) : 0;
      to.heat.push_back(1000 + p[0] + 2 * p[1] * p[2] + 0.1 * double(step_) + own);
      to.flow.push_back({float(p[1]), float(step_) * float(p[0]), float(own)});
      to.level.push_back(int16_t(100 * p[2] + double(step_)));
    }
  }

  void tellAll() {
    step_++;
    std::vector<RankVolume>& all = steps_[step_];
    all = shares();
    change(all);
    for (size_t r = 0; r < sims_.size(); r++) tell(sims_[r], all[r]);
    while (steps_.size() > 300) steps_.erase(steps_.begin());
  }

  static void tell(gxy_sim* sim, const RankVolume& m) {
    const auto array = [](const auto& values, int type, int components, int64_t bytes) {
      return gxy_array{values.empty() ? nullptr : values.data(), type, components, {bytes, 0, 0}, 0, 0};
    };
    EXPECT_EQ(gxy_cells(sim, "block", int64_t(m.points.size()), array(m.points, GXY_FLOAT64, 3, 24),
                        int64_t(m.types.size()), array(m.types, GXY_UINT8, 1, 1),
                        array(m.offsets, GXY_INT64, 1, 8), array(m.connectivity, GXY_INT64, 1, 8)),
              GXY_TAKEN)
        << gxy_message(sim);
    const auto field = [&](const char* name, const gxy_array& values) {
      EXPECT_EQ(gxy_field(sim, "block", 0, name, GXY_OF_POINTS, values), GXY_TAKEN) << gxy_message(sim);
    };
    field("heat", array(m.heat, GXY_FLOAT64, 1, 8));
    field("flow", array(m.flow, GXY_FLOAT32, 3, 12));
    field("level", array(m.level, GXY_INT16, 1, 2));
  }

  const Settings settings_;
  std::vector<gxy_sim*> sims_;
  std::map<int64_t, std::vector<RankVolume>> steps_;
  int64_t step_ = 0;
};

}  // namespace gxy::test
