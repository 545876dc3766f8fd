// SPDX-License-Identifier: Apache-2.0
// simulation LAYOUT: a small simulation that is instrumented with Catalyst 2, of the wave of docs/examples/insitu on 48 x 40 x 32 points.
// Each rank has a slab along z. The stream's name is LAYOUT and the number of ranks.
//   plain    one block for each rank; neighbours have a layer of points in common
//   ghosts   a layer of ghost cells all around, outside of the grid, too. What is of ghosts only is NaN
//   blocks   two blocks for each rank
//   cells    one block for each rank, with values of 48 x 40 x 32 cells
//   gap      as plain, but the last rank has nothing in step 3
//   late     as plain, but the last rank has nothing before step 4
//   atoms    one block for each rank, and 300 particles, which go from rank to rank
#include <catalyst.h>
#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

const int64_t kSize[3] = {48, 40, 32};
constexpr int kSteps = 8;

struct Block {
  int64_t first[3], count[3];  // values, ghosts included
  std::vector<double> height, slope;
  std::vector<int32_t> ghosts;
};

bool inside(const Block& b, const int64_t (&owned)[2], int64_t n, int64_t beyond) {
  const int64_t x = b.first[0] + n % b.count[0], y = b.first[1] + n / b.count[0] % b.count[1],
                z = b.first[2] + n / b.count[0] / b.count[1];
  return x >= 0 && y >= 0 && x < kSize[0] - beyond && y < kSize[1] - beyond && z >= owned[0] &&
         z < owned[1] - beyond;
}

void compute(Block& b, int step, bool ghosts, const int64_t (&owned)[2]) {
  for (size_t n = 0; n < b.height.size(); n++) {
    const int64_t i = int64_t(n);
    const double x = 0.03125 * double(b.first[0] + i % b.count[0] - 3 * step);
    const double y = double(b.first[1] + i / b.count[0] % b.count[1]),
                 z = double(b.first[2] + i / b.count[0] / b.count[1]);
    const bool valid = !ghosts || inside(b, owned, i, 0);
    b.height[n] = valid ? x - x * x * x + 0.03125 * (y - z) : std::nan("");
    for (size_t c = 0; c < 3; c++) b.slope[3 * n + c] = double(c + 1) * b.height[n];
  }
}

void describe(conduit_node* node, const std::string& mesh, Block& b, bool cells) {
  const auto text = [&](const std::string& path, const char* value) {
    catalyst_conduit_node_set_path_char8_str(node, (mesh + path).c_str(), value);
  };
  const auto values = [&](const std::string& path, double* data, size_t count, int64_t offset,
                          int64_t stride) {
    catalyst_conduit_node_set_path_external_float64_ptr_detailed(node, (mesh + path).c_str(), data,
                                                                 int64_t(count), offset, stride, 8, 0);
  };
  text("/coordsets/coords/type", "uniform");
  for (int a = 0; a < 3; a++) {
    const std::string dim(1, "ijk"[a]), axis(1, "xyz"[a]);
    catalyst_conduit_node_set_path_int64(node, (mesh + "/coordsets/coords/dims/" + dim).c_str(),
                                         b.count[a] + cells);
    catalyst_conduit_node_set_path_float64(node, (mesh + "/coordsets/coords/origin/" + axis).c_str(),
                                           0.5 * double(b.first[a]));
    catalyst_conduit_node_set_path_float64(node, (mesh + "/coordsets/coords/spacing/d" + axis).c_str(), 0.5);
  }
  text("/topologies/mesh/type", "uniform"), text("/topologies/mesh/coordset", "coords");
  for (const char* name : {"height", "slope"}) {
    const std::string field = std::string("/fields/") + name;
    text(field + "/association", cells ? "element" : "vertex"), text(field + "/topology", "mesh");
  }
  values("/fields/height/values", b.height.data(), b.height.size(), 0, 8);
  for (int c = 0; c < 3; c++)
    values(std::string("/fields/slope/values/") + "uvw"[c], b.slope.data(), b.height.size(), 8 * c, 24);
  if (b.ghosts.empty()) return;
  text("/fields/ascent_ghosts/association", "element"), text("/fields/ascent_ghosts/topology", "mesh");
  catalyst_conduit_node_set_path_external_int32_ptr_detailed(
      node, (mesh + "/fields/ascent_ghosts/values").c_str(), b.ghosts.data(), int64_t(b.ghosts.size()), 0, 4,
      4, 0);
}

struct Atoms {
  std::vector<double> at, speed;
  std::vector<int32_t> ids;
};

// The particles of a rank in a step. No operation rounds.
Atoms atomsOf(int step, int rank, int ranks) {
  Atoms atoms;
  for (int n = 0; n < 300; n++) {
    if ((n + step) % ranks != rank) continue;
    atoms.at.insert(atoms.at.end(),
                    {0.25 * (n * 7919 % 97), 0.25 * (n * 104729 % 79), 0.25 * (n % 61) + 0.125 * step});
    atoms.speed.push_back(0.5 * n);
    atoms.ids.push_back(n);
  }
  return atoms;
}

void describe(conduit_node* node, Atoms& atoms) {
  const std::string mesh = "catalyst/channels/atoms/data", fields = mesh + "/fields/";
  const int64_t count = int64_t(atoms.ids.size());
  const auto text = [&](const std::string& path, const char* value) {
    catalyst_conduit_node_set_path_char8_str(node, path.c_str(), value);
  };
  text("catalyst/channels/atoms/type", "mesh"), text(mesh + "/coordsets/coords/type", "explicit");
  for (int a = 0; a < 3; a++)
    catalyst_conduit_node_set_path_external_float64_ptr_detailed(
        node, (mesh + "/coordsets/coords/values/" + "xyz"[a]).c_str(), atoms.at.data(), count, 8 * a, 24, 8,
        0);
  text(mesh + "/topologies/mesh/type", "points"), text(mesh + "/topologies/mesh/coordset", "coords");
  for (const char* name : {"id", "speed"})
    text(fields + name + "/association", "vertex"), text(fields + name + "/topology", "mesh");
  catalyst_conduit_node_set_path_external_int32_ptr_detailed(node, (fields + "id/values").c_str(),
                                                             atoms.ids.data(), count, 0, 4, 4, 0);
  catalyst_conduit_node_set_path_external_float64_ptr_detailed(node, (fields + "speed/values").c_str(),
                                                               atoms.speed.data(), count, 0, 8, 8, 0);
}

int run(const std::string& layout, int rank, int ranks) {
  const bool cells = layout == "cells", ghosts = layout == "ghosts";
  const int parts = layout == "blocks" ? 2 : 1, all = ranks * parts;
  const int64_t layers = kSize[2] - (cells ? 0 : 1);  // of cells
  std::vector<Block> blocks;
  int64_t owned[2] = {0, 0};  // layers of values, for ghosts
  for (int part = rank * parts; part < (rank + 1) * parts; part++) {
    const int64_t begin = layers * part / all, end = layers * (part + 1) / all;
    owned[0] = begin, owned[1] = end + 1;
    const int64_t g = ghosts ? 1 : 0;
    Block b{{-g, -g, begin - g},
            {kSize[0] + 2 * g, kSize[1] + 2 * g, end - begin + (cells ? 0 : 1) + 2 * g},
            {},
            {},
            {}};
    b.height.resize(size_t(b.count[0] * b.count[1] * b.count[2])), b.slope.resize(3 * b.height.size());
    if (ghosts) {
      Block cellsOf{
          {b.first[0], b.first[1], b.first[2]}, {b.count[0] - 1, b.count[1] - 1, b.count[2] - 1}, {}, {}, {}};
      for (int64_t n = 0; n < cellsOf.count[0] * cellsOf.count[1] * cellsOf.count[2]; n++)
        b.ghosts.push_back(inside(cellsOf, owned, n, 1) ? 0 : 1);
    }
    blocks.push_back(std::move(b));
  }

  conduit_node* node = catalyst_conduit_node_create();
  catalyst_conduit_node_set_path_char8_str(node, "catalyst/galaxy/name",
                                           (layout + std::to_string(ranks)).c_str());
  const char* axes[] = {"i", "j", "k"};
  for (int a = 0; a < 3; a++) {
    const std::string galaxy = "catalyst/galaxy/";
    catalyst_conduit_node_set_path_int64(node, (galaxy + "size/" + axes[a]).c_str(), kSize[a] + cells);
    catalyst_conduit_node_set_path_float64(node, (galaxy + "origin/" + axes[a]).c_str(), 0);
  }
  catalyst_conduit_node_set_path_float64(node, "catalyst/galaxy/seconds", 60);
  catalyst_conduit_node_set_path_char8_str(node, "catalyst/galaxy/ids", "id");
  int status = catalyst_initialize(node);
  for (int step = 1; step <= kSteps && status == catalyst_status_ok; step++) {
    conduit_node* now = catalyst_conduit_node_create();
    catalyst_conduit_node_set_path_int64(now, "catalyst/state/timestep", step);
    catalyst_conduit_node_set_path_float64(now, "catalyst/state/time", 0.125 * step);
    const bool without = rank == ranks - 1 && (layout == "late" ? step < 4 : layout == "gap" && step == 3);
    if (step == kSteps && layout != "late" && layout != "gap")
      catalyst_conduit_node_set_path_int64(now, "catalyst/galaxy/last", 1);
    catalyst_conduit_node_set_path_char8_str(now, "catalyst/channels/grid/type",
                                             without     ? "none"
                                             : parts > 1 ? "multimesh"
                                                         : "mesh");
    for (size_t b = 0; b < blocks.size() && !without; b++) {
      compute(blocks[b], step, ghosts, owned);
      const std::string mesh = parts > 1 ? "/block" + std::to_string(b) : "";
      describe(now, "catalyst/channels/grid/data" + mesh, blocks[b], cells);
    }
    Atoms atoms = atomsOf(step, rank, ranks);
    if (layout == "atoms") describe(now, atoms);
    status = catalyst_execute(now);
    if (without) status = catalyst_status_ok;
    catalyst_conduit_node_destroy(now);
  }
  const int end = catalyst_finalize(node);
  catalyst_conduit_node_destroy(node);
  return status ? status : end;
}

}  // namespace

int main(int argc, char** argv) {
  int rank, ranks;
  MPI_Init(&argc, &argv), MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int status = run(argc > 1 ? argv[1] : "plain", rank, ranks);
  if (status) std::printf("rank %d: status %d\n", rank, status);
  MPI_Finalize();
  return status;
}
