// SPDX-License-Identifier: Apache-2.0
// Curvilinear and rectilinear grids as unstructured volumes.
#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkRectilinearGridWriter.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkStructuredGridWriter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLRectilinearGridWriter.h>
#include <vtkXMLStructuredGridWriter.h>

#include <cmath>
#include <limits>

#include "tests/io/imported_mesh.h"

namespace gxy {
namespace {

using test::expectSameBlocks;
using test::expectText;
using test::GridFile;
using test::import;
using test::Imported;
using testing::TemporaryFolder;

using Extents = std::array<int, 6>;  // the first and the last point of each axis
const Extents kAll{4, 9, -1, 3, 0, 3};
constexpr uint64_t kAllCells = 5 * 4 * 3;

/// The coordinates of planes, unevenly spaced.
double planeAt(int axis, int i) { return i * (1 + 0.25 * axis) + 0.03 * i * i; }

glm::dvec3 pointAt(bool isCurved, int i, int j, int k) {
  const glm::dvec3 p(planeAt(0, i), planeAt(1, j), planeAt(2, k));
  return isCurved ? p + 0.125 * glm::dvec3(std::sin(p.y), std::cos(p.z), std::sin(p.x)) : p;
}
float valueAt(int i, int j, int k) { return float(i) + 2 * float(j) - 3 * float(k * k); }

template <class Visit>
void eachPoint(const Extents& e, Visit&& visit) {
  for (int k = e[4]; k <= e[5]; k++)
    for (int j = e[2]; j <= e[3]; j++)
      for (int i = e[0]; i <= e[1]; i++) visit(i, j, k);
}

/// A part of the grid, with array "value" at points and "flux" of cells.
vtkSmartPointer<vtkDataSet> latticeOf(bool isCurved, const Extents& e) {
  const auto values = vtkSmartPointer<vtkFloatArray>::New();
  values->SetName("value");
  eachPoint(e, [&](int i, int j, int k) { values->InsertNextValue(valueAt(i, j, k)); });
  vtkSmartPointer<vtkDataSet> set;
  if (isCurved) {
    const auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
    grid->SetExtent(e[0], e[1], e[2], e[3], e[4], e[5]);
    const auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    eachPoint(e, [&](int i, int j, int k) {
      const glm::dvec3 p = pointAt(true, i, j, k);
      points->InsertNextPoint(p.x, p.y, p.z);
    });
    grid->SetPoints(points);
    set = grid;
  } else {
    const auto grid = vtkSmartPointer<vtkRectilinearGrid>::New();
    grid->SetExtent(e[0], e[1], e[2], e[3], e[4], e[5]);
    std::array<vtkSmartPointer<vtkDoubleArray>, 3> axes;
    for (size_t a = 0; a < 3; a++) {
      axes[a] = vtkSmartPointer<vtkDoubleArray>::New();
      for (int i = e[2 * a]; i <= e[2 * a + 1]; i++) axes[a]->InsertNextValue(planeAt(int(a), i));
    }
    grid->SetXCoordinates(axes[0]), grid->SetYCoordinates(axes[1]), grid->SetZCoordinates(axes[2]);
    set = grid;
  }
  set->GetPointData()->SetScalars(values);
  const auto flux = vtkSmartPointer<vtkFloatArray>::New();
  flux->SetName("flux");
  for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); cell++) flux->InsertNextValue(float(cell));
  set->GetCellData()->AddArray(flux);
  return set;
}

vtkSmartPointer<vtkXMLWriter> xmlWriterOf(bool isCurved) {
  if (isCurved) return vtkSmartPointer<vtkXMLStructuredGridWriter>::New();
  return vtkSmartPointer<vtkXMLRectilinearGridWriter>::New();
}

void write(const vtkSmartPointer<vtkXMLWriter>& writer, vtkDataSet* set, const std::string& path) {
  writer->SetInputData(set);
  writer->SetFileName(path.c_str());
  ASSERT_EQ(writer->Write(), 1);
}

void writeLattice(bool isCurved, const Extents& extents, const std::string& path) {
  write(xmlWriterOf(isCurved), latticeOf(isCurved, extents), path);
}

/// The same as an unstructured grid.
GridFile hexahedraOf(bool isCurved, const Extents& e = kAll) {
  GridFile grid;
  grid.pointArrays = {{"value", "Float32", 1, {}}};
  eachPoint(e, [&](int i, int j, int k) {
    grid.points.push_back(pointAt(isCurved, i, j, k));
    grid.pointArrays[0].values.push_back(double(valueAt(i, j, k)));
  });
  const int n = e[1] - e[0] + 1, m = e[3] - e[2] + 1;
  const auto number = [&](int i, int j, int k) {
    return uint32_t(i - e[0] + n * (j - e[2] + m * (k - e[4])));
  };
  eachPoint({e[0], e[1] - 1, e[2], e[3] - 1, e[4], e[5] - 1}, [&](int i, int j, int k) {
    auto& cell = grid.cells.emplace_back(12, std::vector<uint32_t>()).second;
    for (const int z : {k, k + 1})
      for (const auto& [x, y] : {std::pair(i, j), {i + 1, j}, {i + 1, j + 1}, {i, j + 1}})
        cell.push_back(number(x, y, z));
  });
  return grid;
}

Imported expectedOf(bool isCurved) {
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", hexahedraOf(isCurved).vtu());
  return import(folder / "grid.vtu");
}

const char* endingOf(bool isCurved) { return isCurved ? ".vts" : ".vtr"; }

void expectSame(const Imported& found, const Imported& expected, int ranks) {
  ASSERT_EQ(found.errors, std::vector<std::string>(size_t(ranks)));
  expectSameBlocks(found.blocks, expected.blocks);
  EXPECT_EQ(found.mesh.ranges, expected.mesh.ranges);
  EXPECT_EQ(found.mesh.box, expected.mesh.box);
  EXPECT_EQ(found.mesh.report.cells, (std::array<uint64_t, kCellTypes>{0, 0, 0, kAllCells}));
  EXPECT_TRUE(found.warnings.empty());
}

TEST(LatticeMesh, GridsInAnyEncodingAreHexahedra) {
  for (const bool isCurved : {true, false}) {
    const Imported expected = expectedOf(isCurved);
    ASSERT_EQ(expected.blocks.size(), 4u);
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
      for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4}) {
        const TemporaryFolder folder;
        const auto writer = xmlWriterOf(isCurved);
        writer->SetDataMode(mode);
        writer->SetCompressorType(compressor);
        if (mode == vtkXMLWriter::Appended) writer->SetEncodeAppendedData(compressor == vtkXMLWriter::LZ4);
        const std::string path = folder / (std::string("grid") + endingOf(isCurved));
        write(writer, latticeOf(isCurved, kAll), path);
        for (const int ranks : {1, 3}) expectSame(import(path, {}, ranks), expected, ranks);
        EXPECT_EQ(import(path).mesh.name, "grid:value");
      }
  }
}

TEST(LatticeMesh, LegacyFilesAreHexahedraToo) {
  for (const bool isCurved : {true, false})
    for (const int type : {VTK_ASCII, VTK_BINARY}) {
      const TemporaryFolder folder;
      const std::string path = folder / "grid.vtk";
      vtkSmartPointer<vtkDataWriter> writer = vtkSmartPointer<vtkRectilinearGridWriter>::New();
      if (isCurved) writer = vtkSmartPointer<vtkStructuredGridWriter>::New();
      writer->SetInputData(latticeOf(isCurved, kAll));
      writer->SetFileName(path.c_str());
      writer->SetFileType(type);
      ASSERT_EQ(writer->Write(), 1);
      EXPECT_TRUE(isMeshFile(path));
      const Imported found = import(path, {}, 2), expected = expectedOf(isCurved);
      if (type == VTK_BINARY) {
        expectSame(found, expected, 2);
        continue;
      }
      ASSERT_EQ(found.errors[0], "");  // Text is rounded.
      EXPECT_EQ(found.mesh.report.cells, expected.mesh.report.cells);
      EXPECT_EQ(found.mesh.report.points, expected.mesh.report.points);
      EXPECT_EQ(found.mesh.ranges, expected.mesh.ranges);
    }
}

std::string listOf(bool isCurved, const std::vector<std::pair<Extents, std::string>>& pieces) {
  const std::string type = isCurved ? "PStructuredGrid" : "PRectilinearGrid";
  const auto text = [](const Extents& e) {
    std::string all;
    for (const int n : e) all += (all.empty() ? "" : " ") + std::to_string(n);
    return all;
  };
  std::string list = "<VTKFile type=\"" + type + "\" version=\"1.0\" byte_order=\"LittleEndian\">\n<" + type +
                     " WholeExtent=\"" + text(kAll) +
                     "\" GhostLevel=\"0\">\n<PPointData Scalars=\"value\"><PDataArray type=\"Float32\" "
                     "Name=\"value\"/></PPointData>\n";
  list += isCurved ? "<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>\n"
                   : "<PCoordinates><PDataArray type=\"Float64\"/><PDataArray type=\"Float64\"/><PDataArray "
                     "type=\"Float64\"/></PCoordinates>\n";
  for (const auto& [extents, file] : pieces)
    list += "<Piece Extent=\"" + text(extents) + "\" Source=\"" + file + "\"/>\n";
  return list + "</" + type + "></VTKFile>\n";
}

TEST(LatticeMesh, PiecesOnAnyRanksGiveTheSameAsOneFile) {
  const Extents parts[] = {{4, 6, -1, 3, 0, 1}, {6, 9, -1, 3, 0, 1}, {4, 9, -1, 0, 1, 3}, {4, 9, 0, 3, 1, 3}};
  for (const bool isCurved : {true, false}) {
    const TemporaryFolder folder;
    const Imported expected = expectedOf(isCurved);
    std::vector<std::pair<Extents, std::string>> pieces;
    for (const Extents& part : parts) {
      pieces.emplace_back(part, "piece" + std::to_string(pieces.size()) + endingOf(isCurved));
      writeLattice(isCurved, part, folder / pieces.back().second);
    }
    std::swap(pieces[0], pieces[2]);
    const std::string path = folder / (isCurved ? "grid.pvts" : "grid.pvtr");
    writeText(path, listOf(isCurved, pieces));
    for (const int ranks : {1, 2, 3, 4}) expectSame(import(path, {}, ranks), expected, ranks);
  }
}

/// The same pieces with a layer of cells of the other one, marked as duplicate or not.
TEST(LatticeMesh, CellsThatTwoPiecesHaveAreKeptOnce) {
  for (const bool isMarked : {true, false}) {
    const TemporaryFolder folder;
    std::vector<std::pair<Extents, std::string>> pieces{{{4, 7, -1, 3, 0, 3}, "a.vts"},
                                                        {{6, 9, -1, 3, 0, 3}, "b.vts"}};
    for (const auto& [extents, file] : pieces) {
      const auto set = latticeOf(true, extents);
      if (isMarked && file == "a.vts") {
        const auto ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
        ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
        for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); cell++)
          ghosts->InsertNextValue(cell % 3 == 2 ? vtkDataSetAttributes::DUPLICATECELL : 0);
        set->GetCellData()->AddArray(ghosts);
      }
      write(xmlWriterOf(true), set, folder / file);
    }
    writeText(folder / "grid.pvts", listOf(true, pieces));
    const Imported expected = expectedOf(true);
    for (const int ranks : {1, 2}) {
      const Imported found = import(folder / "grid.pvts", {}, ranks);
      ASSERT_EQ(found.errors, std::vector<std::string>(size_t(ranks)));
      expectSameBlocks(found.blocks, expected.blocks);
      EXPECT_EQ(found.mesh.report.ghostCells, isMarked ? 12u : 0u);
      EXPECT_EQ(found.mesh.report.repeatedCells, isMarked ? 0u : 12u);
    }
  }
}

TEST(LatticeMesh, HiddenCellsAndPointsAreThoseOfAnUnstructuredGrid) {
  const auto set = latticeOf(true, kAll);
  GridFile grid = hexahedraOf(true);
  GridFile::Array cellGhosts{"vtkGhostType", "UInt8", 1, {}}, pointGhosts = cellGhosts;
  for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); cell++)
    cellGhosts.values.push_back(cell == 7 ? 32 : cell == 20 ? 8 : cell == 33 ? 1 : cell == 40 ? 16 : 0);
  for (vtkIdType point = 0; point < set->GetNumberOfPoints(); point++)
    pointGhosts.values.push_back(point == 50 ? 2 : point == 61 ? 1 : 0);
  const auto ghostsOf = [](const GridFile::Array& array) {
    const auto ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
    ghosts->SetName(array.name.c_str());
    for (const double v : array.values) ghosts->InsertNextValue(static_cast<unsigned char>(v));
    return ghosts;
  };
  set->GetCellData()->AddArray(ghostsOf(cellGhosts));
  set->GetPointData()->AddArray(ghostsOf(pointGhosts));
  grid.cellArrays = {cellGhosts};
  grid.pointArrays.push_back(pointGhosts);
  const TemporaryFolder folder;
  write(xmlWriterOf(true), set, folder / "grid.vts");
  writeText(folder / "grid.vtu", grid.vtu());
  const Imported found = import(folder / "grid.vts"), expected = import(folder / "grid.vtu");
  ASSERT_EQ(found.errors[0] + expected.errors[0], "");
  for (const Imported* one : {&found, &expected}) {
    EXPECT_EQ(one->mesh.report.ghostCells, 3u);
    EXPECT_EQ(one->mesh.report.flatCells, 0u);
    EXPECT_EQ(one->mesh.report.noDataPoints, 1u);
    EXPECT_EQ(one->mesh.report.cells[3], kAllCells - 3);
  }
  ASSERT_EQ(found.blocks.size(), expected.blocks.size());
  for (const auto& [partition, block] : found.blocks) {
    EXPECT_EQ(block.points, expected.blocks.at(partition).points);
    EXPECT_EQ(block.cells.points, expected.blocks.at(partition).cells.points);
    for (size_t p = 0; p < block.values.size(); p++)
      EXPECT_EQ(std::isnan(block.values[p]), std::isnan(expected.blocks.at(partition).values[p]));
  }
}

std::string errorOfFile(const std::string& path, const std::string& array = {}) {
  const std::vector<std::string> errors = import(path, array, 2).errors;
  EXPECT_EQ(errors[0], errors[1]);
  return errors[0];
}

TEST(LatticeMesh, FlatGridsHaveNoVolume) {
  const TemporaryFolder folder;
  writeLattice(true, {0, 3, 2, 2, 0, 4}, folder / "flat.vts");
  expectText(errorOfFile(folder / "flat.vts"), "it has no cells with a volume");
  expectText(errorOfFile(folder / "flat.vts"), "it has quads (12)");
  writeLattice(false, {0, 3, 2, 2, 0, 0}, folder / "line.vtr");
  expectText(errorOfFile(folder / "line.vtr"), "it has lines (3)");
  writeLattice(false, {1, 1, 2, 2, 0, 0}, folder / "point.vtr");
  expectText(errorOfFile(folder / "point.vtr"), "it has vertices (1)");
}

TEST(LatticeMesh, ValuesOfCellsAreReadAndMissingArraysListed) {
  const TemporaryFolder folder;
  for (const bool isCurved : {true, false}) {
    GridFile grid = hexahedraOf(isCurved);
    grid.cellArrays = {{"flux", "Float32", 1, {}}};
    for (size_t cell = 0; cell < grid.cells.size(); cell++) grid.cellArrays[0].values.push_back(double(cell));
    writeText(folder / "grid.vtu", grid.vtu());
    const Imported expected = import(folder / "grid.vtu", "flux");
    const std::string path = folder / (std::string("grid") + endingOf(isCurved));
    writeLattice(isCurved, kAll, path);
    for (const int ranks : {1, 3}) expectSame(import(path, "flux", ranks), expected, ranks);
    EXPECT_TRUE(expected.mesh.ofCells);
    EXPECT_EQ(expected.mesh.ranges, (std::vector<Range>{{0, double(kAllCells - 1)}}));
    expectText(errorOfFile(path, "none"), "of points the file has 'value', of cells 'flux'");
  }
}

TEST(LatticeMesh, SizesThatTheFileCannotHoldAreRefusedBeforeMemoryIsTaken) {
  const TemporaryFolder folder;
  for (const bool isCurved : {true, false})
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
      for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB}) {
        const std::string path = folder / (std::string("grid") + endingOf(isCurved));
        const auto writer = xmlWriterOf(isCurved);
        writer->SetDataMode(mode);
        writer->SetCompressorType(compressor);
        write(writer, latticeOf(isCurved, kAll), path);
        std::string text = readText(path);
        const std::string stated = "Extent=\"4 9 -1 3 0 3\"";
        for (size_t at = 0; (at = text.find(stated, at)) != std::string::npos; at++)
          text.replace(at, stated.size(), "Extent=\"0 2000 0 2000 0 2000\"");
        writeText(path, text);
        SingleRank alone;
        int64_t asked = 0;
        try {
          loadMesh(path, "value", alone, [&](int64_t bytes) { asked += bytes; });
          ADD_FAILURE() << path;
        } catch (const Error& e) {
          expectText(e.what(), path + ": array '");
        }
        EXPECT_EQ(asked, 0);
      }
}

TEST(LatticeMesh, MemoryIsAskedForBeforeItIsTaken) {
  const TemporaryFolder folder;
  for (const bool isCurved : {true, false}) {
    const std::string path = folder / (std::string("grid") + endingOf(isCurved));
    writeLattice(isCurved, {0, 20, 0, 20, 0, 20}, path);
    SingleRank alone;
    int64_t asked = 0;
    const TakeMemory take = [&](int64_t bytes) { asked += bytes; };
    LoadedMesh loaded = loadMesh(path, {}, alone, take);
    const int64_t ofVtk = 9261 * int64_t(sizeof(glm::dvec3) + sizeof(float));  // its points and values
    EXPECT_GE(asked, bytesOf(loaded.piece) + ofVtk);
    asked = 0;
    const Partitioning single = Partitioning::single(loaded.box);
    const auto mesh = meshOf(std::move(loaded), single, alone, take);
    EXPECT_GE(asked, bytesOf(*mesh));
    EXPECT_THROW(loadMesh(path, {}, alone, [](int64_t) { throw Error("no room"); }), Error);
  }
}

TEST(LatticeMesh, DamagedFilesGiveAnErrorOrAMesh) {
  const testing::QuietLog quiet;
  const TemporaryFolder folder;
  SingleRank alone;
  std::mt19937 random(13);
  for (const bool isCurved : {true, false})
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Appended}) {
      const std::string path = folder / (std::string("grid") + endingOf(isCurved));
      const auto writer = xmlWriterOf(isCurved);
      writer->SetDataMode(mode);
      write(writer, latticeOf(isCurved, {0, 2, 0, 2, 0, 2}), path);
      const std::string text = readText(path);
      size_t failed = 0;
      const auto attempt = [&](const std::string& damaged) {
        writeText(path, damaged);
        try {
          LoadedMesh loaded = loadMesh(path, "value", alone);
          const auto mesh = meshOf(std::move(loaded), Partitioning::single(Box{{0, 0, 0}, {3, 3, 3}}), alone);
          EXPECT_GT(mesh->report.points, 0u);
        } catch (const Error&) {
          failed++;
        }
      };
      for (int i = 0; i < 150; i++) attempt(testing::mutated(text, random));
      EXPECT_GT(failed, 30u);
      failed = 0;
      const size_t step = text.size() / 40, kept = text.find(mode == vtkXMLWriter::Ascii ? "</Points>" : "_");
      for (size_t size = 0; size + 20 < std::min(kept, text.size()); size += step) {
        const size_t before = failed;
        attempt(text.substr(0, size));
        EXPECT_EQ(failed, before + 1) << size;
      }
    }
}

}  // namespace
}  // namespace gxy
