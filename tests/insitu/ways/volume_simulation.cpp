// SPDX-License-Identifier: Apache-2.0
// volume_simulation [FILE] - a simulation with MPI that publishes steps 1 to 4 of a cube of cells of all types, wherever GALAXY_INSITU says;
// or writes each step as FILE.STEP.vtu instead. Steps 1 and 2 have the same points and cells, and so do steps 3 and 4.
#include <mpi.h>

#include <array>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.hpp"
#include "tests/support/mesh_files.h"
#include "tests/support/mixed_meshes.h"

namespace gxy::test {
namespace {

constexpr int kSteps = 4;
constexpr uint32_t kCubes = 6;

MeshPiece meshAt(int step) {
  const double far = step < 3 ? 0.02 : 0.05;
  return cubeOfMixedCells(
      kCubes, [&](const glm::dvec3& p) { return far * p * (1.0 - p) * glm::dvec3(p.y, p.z, p.x); },
      [&](const glm::dvec3& p) { return p.x * p.x + 0.5 * p.y * double(step) + p.z; });
}

/// As gridOf(), and the cells have a value, too.
GridFile sharedGrid(const MeshPiece& mesh, size_t first, size_t last, int step) {
  GridFile grid = gridOf(mesh, first, last);
  grid.cellArrays.push_back({"load", "Float32", 1, {}});
  for (const auto& [type, corners] : grid.cells) {
    const glm::dvec3& p = grid.points[corners[0]];
    grid.cellArrays[0].values.push_back(double(float(p.x * double(step) + 2 * p.y * p.z)));
  }
  return grid;
}

/// Cells `first` to `last` of a mesh, as a simulation has them.
struct Share {
  explicit Share(const GridFile& grid) {
    for (const glm::dvec3& p : grid.points) points.insert(points.end(), {p.x, p.y, p.z});
    values.assign(grid.pointArrays[0].values.begin(), grid.pointArrays[0].values.end());
    ofCells.assign(grid.cellArrays[0].values.begin(), grid.cellArrays[0].values.end());
    for (const auto& [type, corners] : grid.cells) {
      types.push_back(static_cast<unsigned char>(type));
      connectivity.insert(connectivity.end(), corners.begin(), corners.end());
      offsets.push_back(int(connectivity.size()));
    }
  }
  std::vector<double> points;
  std::vector<float> values, ofCells;
  std::vector<unsigned char> types;
  std::vector<int> offsets{0}, connectivity;
};

int publish() {
  int rank = 0, ranks = 1, result = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  gxy::Simulation sim("cube", rank, ranks);
  for (int step = 1; step <= kSteps; step++) {
    const MeshPiece mesh = meshAt(step);
    const size_t n = mesh.cells.size();
    const Share share(
        sharedGrid(mesh, n * size_t(rank) / size_t(ranks), n * size_t(rank + 1) / size_t(ranks), step));
    result |= sim.cells(int64_t(share.points.size() / 3), gxy::row(share.points.data(), 3),
                        int64_t(share.types.size()), gxy::row(share.types.data()),
                        gxy::row(share.connectivity.data()), gxy::row(share.offsets.data()), "block");
    result |= sim.cellsField("value", gxy::row(share.values.data()), GXY_OF_POINTS, "block");
    result |= sim.cellsField("load", gxy::row(share.ofCells.data()), GXY_OF_CELLS, "block");
    if (sim.publish(step, 0.5 * step) != GXY_TAKEN) result = GXY_WRONG;
    if (result != 0) std::cerr << "rank " << rank << ", step " << step << ": " << sim.message() << std::endl;
  }
  sim.close(60);
  return result == 0 ? 0 : 1;
}

void write(const std::string& file) {
  for (int step = 1; step <= kSteps; step++) {
    const MeshPiece mesh = meshAt(step);
    std::ofstream(file + "." + std::to_string(step) + ".vtu", std::ios::binary)
        << sharedGrid(mesh, 0, mesh.cells.size(), step).vtu();
  }
}

}  // namespace
}  // namespace gxy::test

int main(int argc, char** argv) {
  if (argc > 1) {
    gxy::test::write(argv[1]);
    return 0;
  }
  MPI_Init(&argc, &argv);
  const int result = gxy::test::publish();
  MPI_Finalize();
  return result;
}
