// SPDX-License-Identifier: Apache-2.0
// A simulation of several ranks on one thread that publishes random lines or triangles, and the file that has the same.
#pragma once
#include <array>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "core/comm/random.h"
#include "insitu/api/galaxy_insitu.h"
#include "tests/insitu/published.h"

namespace gxy::test {

/// What one rank has in one step.
struct RankMesh {
  std::vector<std::array<double, 4>> points;  ///< x, y, z, and something that is not used
  std::vector<uint8_t> types;
  std::vector<int64_t> offsets{0};
  std::vector<int64_t> connectivity;
  std::vector<double> height;                       ///< by point
  std::vector<std::array<float, 3>> flow, normals;  ///< by point
  std::vector<std::array<uint8_t, 3>> paint;        ///< by point
  std::vector<int16_t> region;                      ///< by cell
  // The same in other types.
  std::vector<std::array<float, 3>> floats;
  std::vector<int32_t> shortOffsets, shortConnectivity;
};

class MiniMesh {
 public:
  struct Settings {
    std::string name = "sea";
    int ranks = 2;
    bool lines = false;
    std::vector<int> types{
        GXY_TRIANGLE};  ///< of cells; of one that is fixed, neither types nor offsets are told as arrays
    uint64_t points = 100, cells = 80;  ///< the most of a rank
    bool floats = false;                ///< positions are floats
    bool shortIndices = false;          ///< offsets and connectivity have 32 bits
    bool fields = true;
    bool normals = false;
    bool zeroNormals = false;  ///< some have no direction
    bool flat = false;         ///< all points have a z of 0
  };
  MiniMesh(const std::string& options, const Settings& settings, uint64_t seed)
      : settings_(settings), random_(seed) {
    for (int r = 0; r < settings.ranks; r++)
      sims_.push_back(gxy_open(settings.name.c_str(), r, settings.ranks, options.c_str()));
  }
  ~MiniMesh() {
    for (gxy_sim* s : sims_) gxy_close(s, 0);
  }
  MiniMesh(const MiniMesh&) = delete;
  MiniMesh& operator=(const MiniMesh&) = delete;

  gxy_sim* rank(int r) { return sims_[size_t(r)]; }
  int64_t published() {
    gxy_stat statistics{};
    gxy_statistics(rank(0), &statistics);
    return statistics.published;
  }
  /// Called with what all ranks have, before it is told.
  std::function<void(std::vector<RankMesh>& ranks)> change = [](auto&) {};
  /// Called for each rank before it publishes.
  std::function<void(gxy_sim* sim, int rank, int64_t step)> beside = [](gxy_sim*, int, int64_t) {};

  void publish() {
    step_++;
    std::vector<RankMesh>& all = steps_[step_];
    for (int r = 0; r < settings_.ranks; r++) all.push_back(random());
    change(all);
    for (int r = 0; r < settings_.ranks; r++) {
      tell(rank(r), all[size_t(r)]);
      beside(rank(r), r, step_);
      EXPECT_NE(gxy_publish(rank(r), step_, 0.5 * double(step_)), GXY_WRONG) << gxy_message(rank(r));
    }
    while (steps_.size() > 300) steps_.erase(steps_.begin());
  }
  void publishLastAndClose(double seconds) {
    step_++;
    std::vector<RankMesh>& all = steps_[step_];
    for (int r = 0; r < settings_.ranks; r++) all.push_back(random());
    change(all);
    for (int r = 0; r < settings_.ranks; r++) {
      RankMesh copy = all[size_t(r)];
      tell(rank(r), copy);
      beside(rank(r), r, step_);
      EXPECT_NE(gxy_publish_last(rank(r), step_, 0.5 * double(step_)), GXY_WRONG) << gxy_message(rank(r));
    }  // Nobody has the arrays any more.
    std::vector<std::thread> threads;
    for (gxy_sim* s : sims_) threads.emplace_back([s, seconds] { gxy_close(s, seconds); });
    for (std::thread& t : threads) t.join();
    sims_.clear();
  }
  int64_t step() const { return step_; }

  /// Writes what all ranks had in a step as a .vtu in text.
  void write(const std::string& path, int64_t step) const {
    const std::vector<RankMesh>& all = steps_.at(step);
    size_t points = 0, cells = 0;
    for (const RankMesh& m : all) points += m.points.size(), cells += m.types.size();
    std::ofstream file(path);
    file.precision(std::numeric_limits<double>::max_digits10);
    file << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
            "byte_order=\"LittleEndian\">\n"
         << "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" << points << "\" NumberOfCells=\"" << cells
         << "\">\n";
    const auto array = [&](const char* type, const char* name, int components, auto write) {
      file << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" NumberOfComponents=\"" << components
           << "\" format=\"ascii\">\n";
      for (const RankMesh& m : all) write(m);
      file << "\n</DataArray>\n";
    };
    const auto rows = [&](const auto& values) {
      for (const auto& row : values)
        for (const auto& v : row) file << double(v) << ' ';
    };
    const auto each = [&](const auto& values) {
      for (const auto& v : values) file << double(v) << ' ';
    };
    file << "<PointData>\n";
    if (settings_.fields) {
      array("Float64", "height", 1, [&](const RankMesh& m) { each(m.height); });
      array("Float32", "flow", 3, [&](const RankMesh& m) { rows(m.flow); });
      array("UInt8", "paint", 3, [&](const RankMesh& m) { rows(m.paint); });
    }
    if (settings_.normals) array("Float32", "Normals", 3, [&](const RankMesh& m) { rows(m.normals); });
    file << "</PointData>\n<CellData>\n";
    if (settings_.fields) array("Int16", "region", 1, [&](const RankMesh& m) { each(m.region); });
    file << "</CellData>\n<Points>\n";
    array("Float64", "Points", 3, [&](const RankMesh& m) {
      for (const auto& p : m.points)
        for (size_t a = 0; a < 3; a++) file << (settings_.floats ? double(float(p[a])) : p[a]) << ' ';
    });
    file << "</Points>\n<Cells>\n";
    int64_t first = 0, begin = 0;
    array("Int64", "connectivity", 1, [&](const RankMesh& m) {
      for (const int64_t point : m.connectivity) file << first + point << ' ';
      first += int64_t(m.points.size());
    });
    array("Int64", "offsets", 1, [&](const RankMesh& m) {
      for (size_t c = 1; c < m.offsets.size(); c++) file << begin + m.offsets[c] << ' ';
      begin += m.offsets.back();
    });
    array("UInt8", "types", 1, [&](const RankMesh& m) {
      for (const uint8_t type : m.types) file << int(type) << ' ';
    });
    file << "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  }

 private:
  double number() { return double(random_.below(1 << 20)) / (1 << 19) - 1; }

  RankMesh random() {
    RankMesh m;
    // The first step says where the domain is.
    const uint64_t points = step_ > 1 && random_.oneIn(4) ? 0 : 5 + random_.below(settings_.points);
    for (uint64_t i = 0; i < points; i++) {
      m.points.push_back({number(), number(), 0.3 * number(), 1e300});
      if (step_ == 1 && i < 2) m.points.back() = {i ? 1. : -1., i ? 1. : -1., i ? 1. : -1., 0};
      if (settings_.flat) m.points.back()[2] = 0;
      m.height.push_back(number());
      m.flow.push_back({float(number()), float(number()), float(number())});
      m.normals.push_back({float(number()), float(number()), 2});
      if (settings_.zeroNormals && i == 0) m.normals.back() = {0, 0, 0};
      m.paint.push_back({uint8_t(random_.below(256)), uint8_t(random_.below(256)), 7});
    }
    const uint64_t cells = points == 0 ? 0 : random_.below(settings_.cells + 1);
    for (uint64_t c = 0; c < cells; c++) {
      const int type = settings_.types[random_.below(settings_.types.size())];
      uint64_t corners = type == GXY_LINE ? 2 : type == GXY_TRIANGLE ? 3 : 4;  // Quads and pixels have 4.
      if (type == GXY_POLY_LINE || type == GXY_TRIANGLE_STRIP || type == GXY_POLYGON)
        corners = random_.below(7);
      m.types.push_back(uint8_t(type));
      for (uint64_t i = 0; i < corners; i++) m.connectivity.push_back(int64_t(random_.below(points)));
      m.offsets.push_back(int64_t(m.connectivity.size()));
      m.region.push_back(int16_t(int64_t(random_.below(1000)) - 500));
    }
    return m;
  }

  void tell(gxy_sim* sim, RankMesh& m) const {
    for (const auto& p : m.points) m.floats.push_back({float(p[0]), float(p[1]), float(p[2])});
    m.shortOffsets.assign(m.offsets.begin(), m.offsets.end());
    m.shortConnectivity.assign(m.connectivity.begin(), m.connectivity.end());
    const auto array = [](const auto& values, int type, int components, int64_t bytes) {
      return gxy_array{values.empty() ? nullptr : values.data(), type, components, {bytes, 0, 0}, 0, 0};
    };
    const gxy_array positions =
        settings_.floats ? array(m.floats, GXY_FLOAT32, 3, 12) : array(m.points, GXY_FLOAT64, 3, 32);
    gxy_array types = array(m.types, GXY_UINT8, 1, 1), offsets = array(m.offsets, GXY_INT64, 1, 8),
              connectivity = array(m.connectivity, GXY_INT64, 1, 8);
    if (settings_.shortIndices)
      offsets = array(m.shortOffsets, GXY_INT32, 1, 4),
      connectivity = array(m.shortConnectivity, GXY_UINT32, 1, 4);
    const int type = settings_.types[0];  // The library keeps it.
    if (settings_.types.size() == 1) types = {&type, GXY_INT32, 1, {0, 0, 0}, 0, 0};
    if (settings_.types.size() == 1 && type != GXY_POLYGON && type != GXY_POLY_LINE &&
        type != GXY_TRIANGLE_STRIP)
      offsets = {};
    EXPECT_EQ(gxy_cells(sim, "surface", int64_t(m.points.size()), positions, int64_t(m.types.size()), types,
                        offsets, connectivity),
              GXY_TAKEN)
        << gxy_message(sim);
    const auto field = [&](const char* name, int of, const gxy_array& values) {
      EXPECT_EQ(gxy_field(sim, "surface", 0, name, of, values), GXY_TAKEN) << gxy_message(sim);
    };
    if (settings_.fields) {
      field("height", GXY_OF_POINTS, array(m.height, GXY_FLOAT64, 1, 8));
      field("flow", GXY_OF_POINTS, array(m.flow, GXY_FLOAT32, 3, 12));
      field("paint", GXY_OF_POINTS, array(m.paint, GXY_UINT8, 3, 3));
      field("region", GXY_OF_CELLS, array(m.region, GXY_INT16, 1, 2));
    }
    if (settings_.normals) field("Normals", GXY_OF_POINTS, array(m.normals, GXY_FLOAT32, 3, 12));
  }

  const Settings settings_;
  Random random_;
  std::vector<gxy_sim*> sims_;
  std::map<int64_t, std::vector<RankMesh>> steps_;
  int64_t step_ = 0;
};

}  // namespace gxy::test
