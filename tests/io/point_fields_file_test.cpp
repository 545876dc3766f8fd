// SPDX-License-Identifier: Apache-2.0
// Further fields of points in files: written with names and components, and read where they are asked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <numeric>

#include "core/comm/error.h"
#include "core/data/gather.h"
#include "core/io/file.h"
#include "core/io/import_geometry.h"
#include "core/io/write_geometry.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;
using testing::ThreadRanks;

/// Points on a curve as particles, one line, or triangles, with values and two fields.
GeometryBlock withFields(GeometryKind kind, uint32_t points) {
  GeometryBlock block;
  block.fields = {{"velo city", 3, {}}, {"age", 1, {}}};
  for (uint32_t i = 0; i < points; i++) {
    block.points.push_back({0.5 * i, 0.25 * (i * i % 7), 0.125 * (i % 3)});
    block.values.push_back(float(i) / 4);
    block.fields[0].values.insert(block.fields[0].values.end(), {float(i), -0.5F, 1.0F / float(i + 1)});
    block.fields[1].values.push_back(float(100 - int(i)));
  }
  for (uint32_t i = 0; i < points; i++) {
    if (kind == GeometryKind::PathLines && i + 1 < points) {
      block.segments.push_back({i, i + 1});
      block.neighbours.push_back({i > 0 ? i - 1 : i, i + 2 < points ? i + 2 : i + 1});
    }
    if (kind == GeometryKind::Triangles && i + 2 < points) block.triangles.push_back({i, i + 1, i + 2});
  }
  block.ids.resize(kind == GeometryKind::Particles   ? points
                   : kind == GeometryKind::PathLines ? block.segments.size()
                                                     : block.triangles.size());
  std::iota(block.ids.begin(), block.ids.end(), uint64_t(0));
  return block;
}

ValuesWanted wantedFields(const std::string& array, std::vector<std::string> fields) {
  ValuesWanted wanted(array);
  wanted.fields = std::move(fields);
  return wanted;
}

std::string readError(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(PointFieldsFile, XmlFormatsKeepAllOfThem) {
  const TemporaryFolder folder;
  for (const char* name : {"g.vtp", "g.vtu"})
    for (const GeometryKind kind :
         {GeometryKind::Particles, GeometryKind::PathLines, GeometryKind::Triangles}) {
      const GeometryBlock block = withFields(kind, 20);
      writeGeometry(folder / name, block, kind, "quarter");
      const GeometryContent read = readGeometry(folder / name, kind, wantedFields("", {"velo city", "age"}));
      EXPECT_EQ(read.block, block);
      EXPECT_EQ(read.array, "quarter");
      EXPECT_EQ(read.leftOut.arrays, 0u);
      const GeometryContent usual = readGeometry(folder / name, kind);
      EXPECT_TRUE(usual.block.fields.empty());
      EXPECT_EQ(usual.block.values, block.values);
      EXPECT_EQ(usual.leftOut.arrays, 2u) << "they are not even read";
      EXPECT_EQ(readGeometry(folder / name, kind, wantedFields("age", {})).block.values,
                block.fields[1].values);
    }
}

TEST(PointFieldsFile, TablesAndMeshesHaveAColumnForEachComponent) {
  const TemporaryFolder folder;
  const GeometryBlock points = withFields(GeometryKind::Particles, 9);
  writeGeometry(folder / "p.csv", points, GeometryKind::Particles, "quarter");
  EXPECT_EQ(readText(folder / "p.csv").substr(0, 70),
            "x,y,z,\"quarter\",\"velo city:0\",\"velo city:1\",\"velo city:2\",\"age\"\n0,0,0,0");
  EXPECT_EQ(
      readGeometry(folder / "p.csv", GeometryKind::Particles, wantedFields("quarter", {"velo city", "age"}))
          .block,
      points);
  const GeometryBlock mesh = withFields(GeometryKind::Triangles, 9);
  writeGeometry(folder / "m.ply", mesh, GeometryKind::Triangles);
  const GeometryBlock read =
      readGeometry(folder / "m.ply", GeometryKind::Triangles, wantedFields("value", {"velo_city_2", "age"}))
          .block;
  EXPECT_EQ(read.values, mesh.values);
  for (size_t i = 0; i < 9; i++) EXPECT_EQ(read.fields.at(0).values.at(i), mesh.fields[0].values[3 * i + 2]);
  EXPECT_EQ(read.fields.at(1), mesh.fields[1]);
  EXPECT_EQ(read.triangles, mesh.triangles);
}

TEST(PointFieldsFile, PropertiesOfAMeshHaveDifferentNames) {
  const TemporaryFolder folder;
  GeometryBlock mesh = withFields(GeometryKind::Triangles, 4);
  mesh.fields = {{"value", 1, {1, 2, 3, 4}}, {"a b", 1, {5, 6, 7, 8}}, {"a_b", 1, {9, 10, 11, 12}}};
  writeGeometry(folder / "m.ply", mesh, GeometryKind::Triangles);
  const GeometryBlock read = readGeometry(folder / "m.ply", GeometryKind::Triangles,
                                          wantedFields("value", {"value_", "a_b", "a_b_"}))
                                 .block;
  EXPECT_EQ(read.values, mesh.values);
  for (size_t f = 0; f < 3; f++) EXPECT_EQ(read.fields.at(f).values, mesh.fields[f].values);
}

TEST(PointFieldsFile, OneThatHasTheNameOfTheValuesIsWrittenOnce) {
  const TemporaryFolder folder;
  GeometryBlock points = withFields(GeometryKind::Particles, 5);
  points.fields[1] = {"same", 1, points.values};
  for (const char* name : {"p.vtp", "p.csv"}) {
    writeGeometry(folder / name, points, GeometryKind::Particles, "same");
    EXPECT_EQ(summariseGeometry(folder / name).arrays.size(), 2u) << name;
    EXPECT_EQ(
        readGeometry(folder / name, GeometryKind::Particles, wantedFields("same", {"same"})).block.values,
        points.values);
  }
}

TEST(PointFieldsFile, OnesThatAreNotThereAreErrors) {
  const TemporaryFolder folder;
  const std::string path = folder / "g.vtp";
  writeGeometry(path, withFields(GeometryKind::Particles, 5), GeometryKind::Particles, "quarter");
  EXPECT_EQ(readError([&] {
              readGeometry(path, GeometryKind::Particles, wantedFields("", {"age", "speed"}));
            }),
            path + ": no array 'speed' of points for `fields`; the file has 'quarter', 'velo city', 'age'");
}

TEST(PointFieldsFile, OnesOfCellsThatAreSplitGoWithTheirPoints) {
  const TemporaryFolder folder;
  const std::string path = folder / "cells.vtk";
  writeText(
      path,
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n"
      "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\nCELL_DATA 2\nSCALARS c float\nLOOKUP_TABLE default\n7 8\n"
      "POINT_DATA 4\nSCALARS p float\nLOOKUP_TABLE default\n10 11 12 13\n"
      "SCALARS c2 float\nLOOKUP_TABLE default\n1 2 3 4\n");
  ValuesWanted wanted = wantedFields("c", {"p"});
  const GeometryBlock read = readGeometry(path, GeometryKind::Triangles, wanted).block;
  EXPECT_EQ(read.values, (std::vector<float>{7, 7, 7, 8, 8, 8}));
  EXPECT_EQ(read.fields.at(0).values, (std::vector<float>{10, 11, 12, 10, 12, 13}));
  EXPECT_NO_THROW(validate(read, GeometryKind::Triangles));
}

TEST(PointFieldsFile, PiecesOnRanksAndOneFileGiveTheSame) {
  const TemporaryFolder folder;
  const GeometryBlock all = withFields(GeometryKind::Particles, 70);
  std::vector<GeometryPiece> pieces;
  for (uint32_t first = 0; first < 70; first += 30) {
    std::vector<uint32_t> members(std::min(30u, 70 - first));
    std::iota(members.begin(), members.end(), first);
    const std::string name = "g" + std::to_string(first) + ".vtp";
    writeGeometry(folder / name, subset(all, GeometryKind::Particles, members), GeometryKind::Particles, "q");
    pieces.push_back({{}, name});
  }
  writeGeometry(folder / "whole.vtp", all, GeometryKind::Particles, "q");
  writeGeometryPieces(folder / "list.pvtp", pieces, all, "q");
  EXPECT_NE(readText(folder / "list.pvtp").find("Name=\"velo city\" NumberOfComponents=\"3\""),
            std::string::npos);
  for (const char* name : {"whole.vtp", "list.pvtp"})
    for (const int ranks : {1, 2, 5}) {  // of 5 ranks two have no piece
      SCOPED_TRACE(std::string(name) + " " + std::to_string(ranks));
      const Partitioning part = Partitioning::lattice(
          {std::vector<double>{0, 10, 35}, std::vector<double>{0, 2}, std::vector<double>{0, 1}}, ranks);
      std::mutex mutex;
      const auto errors = ThreadRanks(ranks).run([&](Collectives& mine) {
        const OwnedGeometry owned = ownedGeometry(loadGeometry(folder / name, GeometryKind::Particles,
                                                               wantedFields("", {"velo city", "age"}), mine),
                                                  part, mine);
        const GeometryBlock gathered = gatherGeometry(owned, mine);
        const std::lock_guard lock(mutex);
        EXPECT_EQ(owned.array, "q");
        ASSERT_EQ(owned.fields.size(), 2u);
        EXPECT_EQ(owned.fields[0].name, "velo city");
        ASSERT_EQ(owned.fields[0].ranges.size(), 4u);
        EXPECT_EQ(owned.fields[0].ranges[0], (Range{0, 69}));
        EXPECT_EQ(owned.fields[0].ranges[1], (Range{-0.5, -0.5}));
        EXPECT_NEAR(owned.fields[0].ranges[3].max, std::sqrt(69.0 * 69 + 0.25), 1e-3);
        EXPECT_EQ(owned.fields[1].ranges, (std::vector<Range>{{31, 100}}));
        EXPECT_EQ(owned.block.fields.size(), 2u) << "also where there are no points";
        EXPECT_TRUE(mine.rank() != 0 || gathered == all);
      });
      EXPECT_EQ(errors, std::vector<std::string>(size_t(ranks)));
    }
}

TEST(PointFieldsFile, TheMagnitudeOfAFieldIsCalledSo) {
  const TemporaryFolder folder;
  writeGeometry(folder / "g.vtp", withFields(GeometryKind::Particles, 5), GeometryKind::Particles, "q");
  SingleRank one;
  const auto arrayOf = [&](const std::string& array, std::vector<std::string> fields) {
    return loadGeometry(folder / "g.vtp", GeometryKind::Particles, wantedFields(array, std::move(fields)),
                        one)
        .geometry.array;
  };
  EXPECT_EQ(arrayOf("velo city", {}), "velo city");
  EXPECT_EQ(arrayOf("velo city", {"velo city"}), "mag(velo city)");
  EXPECT_EQ(arrayOf("age", {"age"}), "age");
}

TEST(PointFieldsFile, PiecesWithOtherNumbersOfComponentsAreAnError) {
  const TemporaryFolder folder;
  GeometryBlock block = withFields(GeometryKind::Particles, 4);
  writeGeometry(folder / "a.vtp", block, GeometryKind::Particles);
  block.fields[0] = {"velo city", 1, {1, 2, 3, 4}};
  writeGeometry(folder / "b.vtp", block, GeometryKind::Particles);
  writeGeometryPieces(folder / "list.pvtp", {{{}, "a.vtp"}, {{}, "b.vtp"}}, block);
  for (const int ranks : {1, 2})
    for (const std::string& error : ThreadRanks(ranks).run([&](Collectives& mine) {
           loadGeometry(folder / "list.pvtp", GeometryKind::Particles, wantedFields("", {"velo city"}), mine);
         }))
      EXPECT_NE(error.find("expected the same"), std::string::npos) << error;
}

}  // namespace
}  // namespace gxy
