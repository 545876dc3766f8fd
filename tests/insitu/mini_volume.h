// SPDX-License-Identifier: Apache-2.0
// A simulation of several ranks on one thread that publishes cells of all types with a volume, and the file that has the same.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
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
  std::vector<double> load;                ///< by cell
  std::vector<std::array<float, 2>> pull;  ///< by cell
  std::vector<uint8_t> ghosts, hidden;     ///< by cell and by point: vtkGhostType
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
    bool ofPoints = true, ofCells = false;  ///< which fields there are
    bool ghosts =
        false;  ///< shares overlap by cells that are marked as duplicates, some cells are hidden, and some points
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
    file.cellArrays = {{"load", "Float64", 1, {}}, {"pull", "Float32", 2, {}}};
    GridFile::Array ghosts{kGhostArray, "UInt8", 1, {}}, hidden = ghosts;
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
      for (const double v : m.load) file.cellArrays[0].values.push_back(v);
      for (const auto& v : m.pull)
        for (const float c : v) file.cellArrays[1].values.push_back(double(c));
      ghosts.values.insert(ghosts.values.end(), m.ghosts.begin(), m.ghosts.end());
      hidden.values.insert(hidden.values.end(), m.hidden.begin(), m.hidden.end());
    }
    if (settings_.ghosts) file.cellArrays.push_back(ghosts);
    if (settings_.ghosts) file.pointArrays.push_back(hidden);
    return file;
  }

 private:
  // Shares are runs of cells, so that neighbouring ranks have points in common. The first rank has none of four.
  std::vector<RankVolume> shares() {
    Random moves(settings_.seed + 1);
    const double far = moved / double(settings_.cubes);
    const MeshPiece mesh = cubeOfMixedCells(
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
    const size_t over = settings_.ghosts ? n / 8 : 0;
    for (size_t r = 0; r < sharing; r++) {
      const size_t begin = n * r / sharing, end = n * (r + 1) / sharing;
      RankVolume& own = ranks[r + ranks.size() - sharing];
      take(mesh, begin - std::min(begin, over), std::min(n, end + over), own);
      for (size_t c = 0; c < own.types.size(); c++) {
        const size_t cell = begin - std::min(begin, over) + c;
        own.ghosts.push_back(cell % 11 == 5 ? 33 : cell < begin || cell >= end ? 1 : 16);
      }
    }
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
      const glm::dvec3& p = mesh.points[cell[0]];
      const double own = settings_.differ ? double(begin) : 0;
      to.load.push_back(c % 13 == 12 ? double(NAN) : 10 * p.x + p.y * double(step_) + 0.01 * double(c) + own);
      to.pull.push_back({float(p.z + double(step_)), float(c % 5)});
    }
    for (size_t p = 0; p < to.points.size(); p++) to.hidden.push_back(p % 17 == 16 ? 2 : 1);
    for (const auto& p : to.points) {
      const double own = settings_.differ ? double(begin) : 0;
      to.heat.push_back(1000 + p[0] + 2 * p[1] * p[2] + 0.1 * double(step_) + own);
      to.flow.push_back({float(p[1]), float(step_) * float(p[0]), float(own)});
      to.level.push_back(int16_t(100 * p[0] * p[2] + double(step_)));
    }
  }

  void tellAll() {
    step_++;
    std::vector<RankVolume>& all = steps_[step_];
    all = shares();
    change(all);
    for (size_t r = 0; r < sims_.size(); r++) tell(sims_[r], all[r], settings_);
    while (steps_.size() > 300) steps_.erase(steps_.begin());
  }

  static void tell(gxy_sim* sim, const RankVolume& m, const Settings& settings) {
    const auto array = [](const auto& values, int type, int components, int64_t bytes) {
      return gxy_array{values.empty() ? nullptr : values.data(), type, components, {bytes, 0, 0}, 0, 0};
    };
    EXPECT_EQ(gxy_cells(sim, "block", int64_t(m.points.size()), array(m.points, GXY_FLOAT64, 3, 24),
                        int64_t(m.types.size()), array(m.types, GXY_UINT8, 1, 1),
                        array(m.offsets, GXY_INT64, 1, 8), array(m.connectivity, GXY_INT64, 1, 8)),
              GXY_TAKEN)
        << gxy_message(sim);
    const auto field = [&](const char* name, const gxy_array& values, int of) {
      EXPECT_EQ(gxy_field(sim, "block", 0, name, of, values), GXY_TAKEN) << gxy_message(sim);
    };
    if (settings.ofPoints) {
      field("heat", array(m.heat, GXY_FLOAT64, 1, 8), GXY_OF_POINTS);
      field("flow", array(m.flow, GXY_FLOAT32, 3, 12), GXY_OF_POINTS);
      field("level", array(m.level, GXY_INT16, 1, 2), GXY_OF_POINTS);
    }
    if (settings.ofCells) {
      field("load", array(m.load, GXY_FLOAT64, 1, 8), GXY_OF_CELLS);
      field("pull", array(m.pull, GXY_FLOAT32, 2, 8), GXY_OF_CELLS);
    }
    if (!settings.ghosts) return;
    field(kGhostArray, array(m.ghosts, GXY_UINT8, 1, 1), GXY_OF_CELLS);
    field(kGhostArray, array(m.hidden, GXY_UINT8, 1, 1), GXY_OF_POINTS);
  }

  const Settings settings_;
  std::vector<gxy_sim*> sims_;
  std::map<int64_t, std::vector<RankVolume>> steps_;
  int64_t step_ = 0;
};

}  // namespace gxy::test
