// SPDX-License-Identifier: Apache-2.0
// Imports of files of unstructured volumes, on ranks that are threads.
#pragma once
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/io/file.h"
#include "core/io/import_mesh.h"
#include "tests/io/fixtures.h"
#include "tests/support/mesh_files.h"

namespace gxy::test {

using testing::TemporaryFolder;
using testing::ThreadRanks;

struct Imported {
  std::map<int, MeshBlock> blocks;  // of all ranks
  Mesh mesh;                        // of rank 0, without blocks
  std::vector<std::string> warnings, errors;
};

inline Imported import(const std::string& path, const std::string& array = {}, int ranks = 1,
                       std::array<int, 3> parts = {2, 1, 2}) {
  Imported imported;
  std::mutex mutex;
  imported.errors = ThreadRanks(ranks).run([&](Collectives& mine) {
    std::vector<std::string> warnings;
    LoadedMesh loaded = loadMesh(path, array, mine, {}, &warnings);
    std::array<std::vector<double>, 3> faces;
    for (int a = 0; a < 3; a++) {
      const double lo = loaded.box.lo[a], hi = loaded.box.hi[a];
      faces[size_t(a)] = evenFaces(lo, hi > lo ? hi : lo + 1, parts[size_t(a)], 0);
    }
    const auto mesh = meshOf(std::move(loaded), Partitioning::lattice(faces, ranks), mine, {}, &warnings);
    const std::lock_guard lock(mutex);
    imported.blocks.insert(mesh->blocks.begin(), mesh->blocks.end());
    if (mine.rank() != 0) return;
    imported.mesh = *mesh;
    imported.mesh.blocks.clear();
    imported.warnings = warnings;
  });
  return imported;
}

inline std::string errorOf(const GridFile& grid, const std::string& array = {}, int ranks = 1) {
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  const std::vector<std::string> errors = import(folder / "grid.vtu", array, ranks).errors;
  for (const std::string& error : errors) EXPECT_EQ(error, errors[0]);
  return errors[0];
}

inline void expectText(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

inline void expectSameBlocks(const std::map<int, MeshBlock>& a, const std::map<int, MeshBlock>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [partition, block] : a) {
    const MeshBlock& other = b.at(partition);
    EXPECT_TRUE(block.points == other.points && block.cells.points == other.cells.points &&
                block.values == other.values && block.cellValues == other.cellValues &&
                block.neighbours == other.neighbours && block.shell == other.shell)
        << partition;
  }
}

}  // namespace gxy::test
