// SPDX-License-Identifier: Apache-2.0
// What a simulation hands to Catalyst, and the implementation of Galaxy that Catalyst opens.
#pragma once
#include <catalyst.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/insitu/catalyst/recorder.h"

namespace gxy::test {

inline constexpr int kWrong = 100;
inline const std::string kMesh = "catalyst/channels/grid/data", kField = kMesh + "/fields/t";

template <class T>
constexpr int64_t idOf() {  // of Conduit's types
  if (std::is_floating_point_v<T>) return sizeof(T) == 4 ? 11 : 12;
  return (std::is_signed_v<T> ? 3 : 7) + (sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3);
}

/// A tree of nodes that a simulation makes.
class Tree {
 public:
  Tree() : node_(catalyst_conduit_node_create()) {}
  ~Tree() { catalyst_conduit_node_destroy(node_); }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;
  conduit_node* node() const { return node_; }
  void set(const std::string& path, const char* text) {
    catalyst_conduit_node_set_path_char8_str(node_, path.c_str(), text);
  }
  void set(const std::string& path, int value) {
    catalyst_conduit_node_set_path_int64(node_, path.c_str(), value);
  }
  void set(const std::string& path, double value) {
    catalyst_conduit_node_set_path_float64(node_, path.c_str(), value);
  }
  template <class T>
  void external(const std::string& path, const T* data, int64_t count, int64_t stride = sizeof(T),
                int64_t offset = 0) {
    stand_in_set_external(node_, path.c_str(), idOf<T>(), const_cast<T*>(data), count, offset, stride, 0);
  }
  template <class T>
  void external(const std::string& path, const std::vector<T>& data) {
    external(path, data.data(), int64_t(data.size()));
  }
  void remove(const std::string& path) { stand_in_remove(node_, path.c_str()); }

  void step(int step = 1) { set("catalyst/state/timestep", step), set("catalyst/state/time", 0.5 * step); }
  /// A uniform grid of some points, which begins at `first` of a grid with origin (-1, 2, 0) and spacing 0.25.
  void grid(const std::array<int, 3>& points, const std::array<int, 3>& first = {},
            const std::string& mesh = kMesh) {
    const double origin[] = {-1, 2, 0};
    for (size_t a = 0; a < 3; a++) {
      const std::string coords = mesh + "/coordsets/coords/", axis(1, "xyz"[a]);
      set(coords + "dims/" + "ijk"[a], points[a]);
      set(coords + "origin/" + axis, origin[a] + 0.25 * first[a]);
      set(coords + "spacing/d" + axis, 0.25);
    }
    set(mesh + "/coordsets/coords/type", "uniform");
    set(mesh + "/topologies/mesh/type", "uniform");
    set(mesh + "/topologies/mesh/coordset", "coords");
    set("catalyst/channels/grid/type", mesh == kMesh ? "mesh" : "multimesh");
  }
  void field(const std::string& association, const std::string& path = kField) {
    set(path + "/association", association.c_str()), set(path + "/topology", "mesh");
  }

 private:
  conduit_node* node_;
};

inline std::vector<float> numbered(size_t count) {
  std::vector<float> values(count);
  std::iota(values.begin(), values.end(), 0.f);
  return values;
}

class Catalyst : public testing::Test {
 protected:
  Catalyst() {
    for (const char* name :
         {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID", "GALAXY_INSITU", "GALAXY_CATALYST"})
      unsetenv(name);
    setenv("CATALYST_IMPLEMENTATION_NAME", "galaxy", 1);
    setenv("CATALYST_IMPLEMENTATION_PATHS", CATALYST_GALAXY, 1);
    testing::internal::CaptureStderr();
  }
  ~Catalyst() override {
    catalyst_finalize(params_.node());
    testing::internal::GetCapturedStderr();
  }
  /// What was said on standard error since.
  std::string said() {
    std::string text = testing::internal::GetCapturedStderr();
    testing::internal::CaptureStderr();
    return text;
  }
  void ranks(int rank, int of) {
    params_.set("catalyst/galaxy/rank", rank), params_.set("catalyst/galaxy/ranks", of);
  }
  void whole(const std::array<int, 3>& size, bool origin = true) {
    for (size_t a = 0; a < 3; a++) {
      params_.set(std::string("catalyst/galaxy/size/") + "ijk"[a], size[a]);
      if (origin)
        params_.set(std::string("catalyst/galaxy/origin/") + "xyz"[a], a == 0 ? -1. : a == 1 ? 2. : 0.);
    }
  }
  int initialize() { return catalyst_initialize(params_.node()); }
  int execute(const Tree& tree) { return catalyst_execute(tree.node()); }
  void expectSaid(const std::string& what, const std::string& of = "") {
    const std::string text = said();
    EXPECT_NE(text.find(what), std::string::npos) << of << ": " << text;
    EXPECT_EQ(text.rfind("galaxy: ", 0), 0) << text;
  }
  void expectGrid(int block, const std::array<int64_t, 3>& size, const std::array<int64_t, 3>& first,
                  const std::array<int64_t, 3>& count) {
    const auto& grid = recorded().grids.at({"grid", block});
    EXPECT_EQ(grid.size, size);
    EXPECT_EQ(grid.first, first);
    EXPECT_EQ(grid.count, count);
    EXPECT_EQ(grid.origin, (std::array<double, 3>{-1, 2, 0}));
    EXPECT_EQ(grid.spacing, (std::array<double, 3>{0.25, 0.25, 0.25}));
  }
  const std::vector<double>& read(int block = 0, const std::string& field = "t") {
    return recorded().read[{"grid", block, field}];
  }

  Tree params_;
};

/// One block of 4 x 3 x 2 points with a field of them.
struct Simple : Tree {
  Simple() { step(), grid({4, 3, 2}), field("vertex"), external(kField + "/values", values); }
  std::vector<float> values = numbered(24);
};

/// Elements of one shape beside a grid, with a field of vertices and one of elements.
struct Surface : Simple {
  Surface(const char* shape, size_t points, std::vector<int32_t> numbers, size_t count)
      : x(points), y(points), z(points, 3), corners(std::move(numbers)), height(points), region(count) {
    std::iota(x.begin(), x.end(), 0.5), std::iota(y.begin(), y.end(), -1);
    for (size_t p = 0; p < points; p++) y[p] *= y[p];
    std::iota(height.begin(), height.end(), 7.f), std::iota(region.begin(), region.end(), 100);
    set("catalyst/channels/sea/type", "mesh"), set(kSea + "/coordsets/coords/type", "explicit");
    external(kSea + "/coordsets/coords/values/x", x), external(kSea + "/coordsets/coords/values/y", y);
    external(kSea + "/coordsets/coords/values/z", z);
    set(kSea + "/topologies/mesh/type", "unstructured"), set(kSea + "/topologies/mesh/coordset", "coords");
    set(kSea + "/topologies/mesh/elements/shape", shape);
    external(kSea + "/topologies/mesh/elements/connectivity", corners);
    field("vertex", kSea + "/fields/height"), external(kSea + "/fields/height/values", height);
    field("element", kSea + "/fields/region"), external(kSea + "/fields/region/values", region);
  }
  static inline const std::string kSea = "catalyst/channels/sea/data";
  std::vector<double> x, y, z;
  std::vector<int32_t> corners;
  std::vector<float> height;
  std::vector<int16_t> region;
};

}  // namespace gxy::test
