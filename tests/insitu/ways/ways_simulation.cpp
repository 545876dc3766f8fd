// SPDX-License-Identifier: Apache-2.0
// ways_simulation CASE [FILE] - a simulation with MPI that publishes steps 1 to 2 of a random decomposition, wherever GALAXY_INSITU says; or
// writes each step as FILE.STEP.vti instead. CASE is JSON: points (or cells) along x, y and z, type (0 to 9), components, layout (0 to 4), of
// (0 points, 1 cells), seed, and whether it is in one world with a server.
#include "insitu/api/galaxy_insitu_mpi.h"

#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/insitu/mini_simulation.h"
#include "tests/insitu/random_blocks.h"

namespace gxy::test {
namespace {

constexpr int kSteps = 2;
constexpr const char* kTypes[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                  "UInt32", "Int64", "UInt64", "Float32", "Float64"};

struct Case {
  explicit Case(const nlohmann::json& c)
      : field{"a", ScalarType(c.at("type").get<int>()), c.at("components")},
        layout(kLayouts[c.at("layout").get<size_t>()]),
        of(c.at("of")),
        seed(c.at("seed")),
        world(c.at("world")) {
    grid.points = c.at("points").get<Index3>();
    grid.origin = {-1, 0.25, 2};
    grid.spacing = {0.125, 0.25, 0.5};
  }
  Grid grid;
  MiniField field;
  Layout layout;
  int of;
  uint64_t seed;
  bool world;
};

/// The fields are read by MiniArray: of one block with all points.
void write(const Case& c, const std::string& file) {
  const Extent all{{0, 0, 0}, c.grid.points};
  MiniArray values(c.field, all, Layout::Together);
  for (int step = 1; step <= kSteps; step++) {
    values.fill(c.grid, step, 0);
    std::string extent;
    for (const int64_t n : c.grid.points)
      extent += "0 " + std::to_string(c.of == GXY_OF_CELLS ? n : n - 1) + " ";
    const std::string data = c.of == GXY_OF_CELLS ? "CellData" : "PointData";
    const uint64_t bytes = uint64_t(all.count()) * bytesOf(c.field.type) * uint64_t(c.field.components);
    std::ofstream out(file + "." + std::to_string(step) + ".vti", std::ios::binary);
    out << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<ImageData WholeExtent=\""
        << extent << "\" Origin=\"-1 0.25 2\" Spacing=\"0.125 0.25 0.5\">\n<Piece Extent=\"" << extent
        << "\">\n<" << data << "><DataArray Name=\"a\" type=\"" << kTypes[int(c.field.type)]
        << "\" NumberOfComponents=\"" << c.field.components << "\" format=\"appended\" offset=\"0\"/></"
        << data << ">\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    out.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    out.write(static_cast<const char*>(values.array().data), std::streamsize(bytes));
    out << "\n</AppendedData>\n</VTKFile>\n";
    out.close();
    if (!out) throw std::runtime_error("cannot write " + file);
  }
}

int publish(const Case& c, MPI_Comm comm) {
  int rank = 0, ranks = 1, result = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  gxy_sim* sim = gxy_open_mpi("ways", comm, nullptr);
  Random random(c.seed);
  std::vector<MiniArray> arrays;
  int next = 0;
  const auto tell = [&](const Extent& owned, const gxy_array& values) {
    result |= gxy_grid(sim, "grid", next, c.of, c.grid.points.data(), owned.first.data(), owned.points.data(),
                       &c.grid.origin[0], &c.grid.spacing[0]);
    result |= gxy_field(sim, "grid", next++, "a", c.of, values);
  };
  for (const insitu::Block& block : insitu::randomBlocks(random, c.grid.points, ranks)) {
    if (block.rank != rank) continue;
    arrays.emplace_back(c.field, block.extent, c.layout);
    tell(block.extent, arrays.back().array());
  }
  if (next == 0) tell({}, {nullptr, int(c.field.type), c.field.components, {0, 0, 0}, 0, 0});
  for (int step = 1; step <= kSteps; step++) {
    for (MiniArray& values : arrays) values.fill(c.grid, step, 0);
    if (gxy_publish(sim, step, 0.5 * step) != GXY_TAKEN) result = GXY_WRONG;
    if (result != 0)
      std::cerr << "rank " << rank << ", step " << step << ": " << gxy_message(sim) << std::endl;
  }
  gxy_close(sim, 60);
  return result == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gxy::test

int main(int argc, char** argv) {
  using namespace gxy::test;
  if (argc < 2) return 2;
  int given = 0, result = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &given);
  const Case c(nlohmann::json::parse(argv[1]));
  if (argc > 2) {
    write(c, argv[2]);
  } else {
    result = publish(c, c.world ? gxy_split_world() : MPI_COMM_WORLD);
    if (c.world) gxy_end_world();
  }
  MPI_Finalize();
  return result;
}
