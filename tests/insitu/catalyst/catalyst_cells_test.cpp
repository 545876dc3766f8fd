// SPDX-License-Identifier: Apache-2.0
// libcatalyst-galaxy.so takes lines, faces and cells with a volume.
#include <iterator>
#include <tuple>

#include "tests/insitu/catalyst/simulated.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

TEST_F(Catalyst, LinesTrianglesAndQuadsMayBeOthersInEachStep) {
  for (const auto& [shape, each] : {std::pair("line", 2), std::pair("tri", 3), std::pair("quad", 4)}) {
    ASSERT_EQ(initialize(), 0);
    for (const int count : {2, 1, 0}) {
      std::vector<int32_t> corners;
      for (int c = 0; c < count * each; c++) corners.push_back(c % each);
      Surface tree(shape, 4, corners, size_t(count));
      tree.step(3 - count);
      EXPECT_EQ(execute(tree), 0) << said();
      const auto& cells = recorded().points.at("sea");
      EXPECT_EQ(cells.pointsOfEach, each);
      EXPECT_EQ(cells.at.size(), 12u);
      EXPECT_EQ(cells.corners, std::vector<double>(corners.begin(), corners.end()));
      EXPECT_EQ((recorded().read[{"sea", 0, "height"}]),
                std::vector<double>(tree.height.begin(), tree.height.end()));
      EXPECT_EQ((recorded().read[{"sea", 0, "region"}]),
                std::vector<double>(tree.region.begin(), tree.region.end()));
    }
    EXPECT_EQ(said(), "");
    EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  }
}

TEST_F(Catalyst, ElementsWithAVolumeAreTakenWithFieldsOfBoth) {
  for (const auto& [shape, type, each] :
       {std::tuple("tet", GXY_TETRAHEDRON, 4), std::tuple("pyramid", GXY_PYRAMID, 5),
        std::tuple("wedge", GXY_WEDGE, 6), std::tuple("hex", GXY_HEXAHEDRON, 8)}) {
    ASSERT_EQ(initialize(), 0);
    std::vector<int32_t> corners;
    for (int c = 0; c < 2 * each; c++) corners.push_back(c % each);
    Surface tree(shape, 8, corners, 2);
    EXPECT_EQ(execute(tree), 0);
    EXPECT_EQ(said(), "");
    const auto& cells = recorded().points.at("sea");
    EXPECT_EQ(cells.kinds, std::vector<double>(2, type));
    EXPECT_EQ(cells.corners, std::vector<double>(corners.begin(), corners.end()));
    EXPECT_EQ((recorded().read[{"sea", 0, "height"}]),
              std::vector<double>(tree.height.begin(), tree.height.end()));
    EXPECT_EQ((recorded().read[{"sea", 0, "region"}]),
              std::vector<double>(tree.region.begin(), tree.region.end()));
    EXPECT_EQ(recorded().ofCells["sea"], std::set<std::string>{"region"});
    EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  }
}

/// A pyramid, a tetrahedron and a wedge.
struct Mixed : Surface {
  Mixed() : Surface("mixed", 8, {0, 1, 2, 3, 4, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5}, 3) {
    for (const auto& [name, number] : {std::pair("tet", 1), std::pair("wedge", 5), std::pair("pyramid", 7)})
      set(kElements + "shape_map/" + name, number);
    external(kElements + "shapes", shapes), external(kElements + "sizes", sizes);
    external(kElements + "offsets", offsets);
    remove(kSea + "/fields/region");
  }
  static inline const std::string kElements = kSea + "/topologies/mesh/elements/";
  std::vector<uint8_t> shapes{7, 1, 5};
  std::vector<int64_t> sizes{5, 4, 6}, offsets{0, 5, 9};
};

TEST_F(Catalyst, ElementsMayBeMixed) {
  for (const bool offsets : {true, false}) {
    ASSERT_EQ(initialize(), 0);
    Mixed tree;
    if (!offsets) tree.remove(Mixed::kElements + "offsets");
    EXPECT_EQ(execute(tree), 0) << said();
    const auto& cells = recorded().points.at("sea");
    EXPECT_EQ(cells.kinds, (std::vector<double>{GXY_PYRAMID, GXY_TETRAHEDRON, GXY_WEDGE}));
    EXPECT_EQ(cells.begins, (std::vector<double>{0, 5, 9, 15}));
    EXPECT_EQ(cells.corners, std::vector<double>(tree.corners.begin(), tree.corners.end()));
    EXPECT_EQ(said(), "");
    EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  }
}

TEST_F(Catalyst, GhostsOfElementsWithAVolumeAreLeftOut) {
  ASSERT_EQ(initialize(), 0);
  Mixed tree;
  const std::vector<int32_t> ghosts{0, 1, 0};
  tree.field("element", Surface::kSea + "/fields/ascent_ghosts");
  tree.external(Surface::kSea + "/fields/ascent_ghosts/values", ghosts);
  EXPECT_EQ(execute(tree), 0) << said();
  const auto& cells = recorded().points.at("sea");
  EXPECT_EQ(cells.kinds, (std::vector<double>{GXY_PYRAMID, GXY_WEDGE}));
  EXPECT_EQ(cells.begins, (std::vector<double>{0, 5, 11}));
  EXPECT_EQ(cells.corners, (std::vector<double>{0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 5}));
}

TEST_F(Catalyst, GhostsOfElementsServeFieldsOfElements) {
  const std::string ghosts = Surface::kSea + "/fields/ascent_ghosts",
                    bits = Surface::kSea + "/fields/vtkGhostType";
  const std::vector<int32_t> ofAscent{0, 1, 2};
  const std::vector<uint8_t> ofVtk{16, 33, 1};
  for (const bool areBits : {false, true}) {
    ASSERT_EQ(initialize(), 0);
    Mixed tree;
    tree.field("element", Surface::kSea + "/fields/region");
    tree.external(Surface::kSea + "/fields/region/values", tree.region);
    tree.field("element", areBits ? bits : ghosts);
    if (areBits)
      tree.external(bits + "/values", ofVtk);
    else
      tree.external(ghosts + "/values", ofAscent);
    EXPECT_EQ(execute(tree), 0) << said();
    EXPECT_EQ(recorded().points.at("sea").kinds,
              (std::vector<double>{GXY_PYRAMID, GXY_TETRAHEDRON, GXY_WEDGE}));
    EXPECT_EQ((recorded().read[{"sea", 0, "vtkGhostType"}]),
              areBits ? (std::vector<double>{16, 33, 1}) : (std::vector<double>{0, 1, 32}));
    EXPECT_EQ((recorded().fields.at({"sea", 0, "vtkGhostType"}).type), GXY_UINT8);
    EXPECT_EQ(recorded().ofCells["sea"], (std::set<std::string>{"region", "vtkGhostType"}));
    EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  }
}

/// Two cubes beside each other, x being the fastest.
const std::vector<double> kTwoCubes{0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10};

/// The same as a curvilinear grid.
struct Curved : Surface {
  Curved() : Surface("hex", 12, {}, 2) {
    set(kSea + "/topologies/mesh/type", "structured");
    set(Mixed::kElements + "dims/i", 2), set(Mixed::kElements + "dims/j", 1),
        set(Mixed::kElements + "dims/k", 1);
  }
};

TEST_F(Catalyst, CurvilinearGridsAreHexahedra) {
  ASSERT_EQ(initialize(), 0);
  Curved tree;
  EXPECT_EQ(execute(tree), 0) << said();
  const auto& cells = recorded().points.at("sea");
  EXPECT_EQ(cells.kinds, std::vector<double>(2, GXY_HEXAHEDRON));
  EXPECT_EQ(cells.corners, kTwoCubes);
  EXPECT_EQ(cells.at.size(), 36u);
  EXPECT_EQ(cells.at[3], 1.5);
  EXPECT_EQ((recorded().read[{"sea", 0, "region"}]), (std::vector<double>{100, 101}));
  tree.step(2), tree.remove(Mixed::kElements + "dims/k");
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid(
      "topologies/mesh: a structured topology of two dimensions, or with strides, is not taken so far");
}

TEST_F(Catalyst, RectilinearGridsAreHexahedraBetweenTheirPlanes) {
  ASSERT_EQ(initialize(), 0);
  Surface tree("hex", 12, {}, 2);
  const std::string coords = Surface::kSea + "/coordsets/coords";
  tree.set(Surface::kSea + "/topologies/mesh/type", "rectilinear"), tree.set(coords + "/type", "rectilinear");
  std::vector<float> x{0, 1, 3}, y{0, 5};
  const std::vector<double> z{1, 7};
  tree.external(coords + "/values/x", x), tree.external(coords + "/values/y", y);
  tree.external(coords + "/values/z", z);
  for (const int step : {1, 2, 3}) {
    tree.step(step);
    if (step == 3) x[2] = 4;
    EXPECT_EQ(execute(tree), 0) << said();
    EXPECT_EQ(recorded().points.at("sea").corners, kTwoCubes);
    const std::vector<double>& at = recorded().points.at("sea").at;
    ASSERT_EQ(at.size(), 36u);
    EXPECT_EQ(std::vector<double>(at.begin(), at.begin() + 12),
              (std::vector<double>{0, 0, 1, 1, 0, 1, step == 3 ? 4. : 3., 0, 1, 0, 5, 1}));
    EXPECT_EQ(at.back(), 7);
  }
  EXPECT_EQ((recorded().read[{"sea", 0, "height"}]),
            std::vector<double>(tree.height.begin(), tree.height.end()));
  EXPECT_EQ((recorded().read[{"sea", 0, "region"}]), (std::vector<double>{100, 101}));
}

TEST_F(Catalyst, WrongElementsWithAVolumeAreTold) {
  const auto expect = [&](const Tree& tree, const std::string& what) {
    ASSERT_EQ(initialize(), 0);
    EXPECT_EQ(execute(tree), kWrong) << what;
    expectSaid(what, what);
    EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  };
  Mixed unknown, gap, fewer, more;
  unknown.shapes[1] = 9;
  expect(unknown, "elements/shapes: element 1 is of 9, expected one of the numbers in shape_map");
  gap.offsets[2] = 10;
  expect(gap, "elements/offsets: element 2 begins at 10, expected 9, where the one before ends");
  fewer.external(Mixed::kElements + "offsets", fewer.offsets.data(), 2);
  expect(fewer, "elements/offsets: found 2 numbers, expected 3");
  more.external(Mixed::kElements + "connectivity", more.corners.data(), 14);
  expect(more, "elements/connectivity: found 14 points, expected 15, those of all elements");
  Curved curved;
  curved.set(Mixed::kElements + "dims/i", 1);
  expect(curved, "coords/values: found 12 points, expected 8, those of the elements");
  Surface without("tet", 4, {0, 1, 2, 3}, 1);
  without.remove(Surface::kSea + "/fields/height"), without.remove(Surface::kSea + "/fields/region");
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(without), 0);
  expectSaid("topologies/mesh: elements with a volume without a field, left out");
}

TEST_F(Catalyst, OtherElementsAreLeftOutAndWrongOnesTold) {
  ASSERT_EQ(initialize(), 0);
  Surface solid("polyhedral", 4, {0, 1, 2, 3}, 1);
  EXPECT_EQ(execute(solid), 0);
  expectSaid(
      "topologies/mesh: elements of shape \"polyhedral\" are not taken so far, expected \"line\", \"tri\", "
      "\"quad\", \"tet\", \"hex\", \"wedge\" or \"pyramid\", or \"mixed\", left out");
  Mixed others;
  others.step(2), others.set(Mixed::kElements + "shape_map/polygonal", 9);
  EXPECT_EQ(execute(others), 0);
  expectSaid("topologies/mesh: elements of shape \"polygonal\" are not taken so far");
  EXPECT_TRUE(recorded().points.empty());
  Surface some("tri", 4, {0, 1, 2, 3}, 1);
  some.step(3);
  EXPECT_EQ(execute(some), kWrong);
  expectSaid("elements/connectivity: found 4 points, expected 3 for each of the elements");
  Surface fewer("tri", 4, {0, 1, 2}, 2);
  fewer.step(4);
  EXPECT_EQ(execute(fewer), kWrong);
  expectSaid("fields/region/values: found 2 values, expected 1, one for each of the elements");
}

// As NoTreeEndsTheSimulation, of cells.
TEST_F(Catalyst, NoTreeOfCellsEndsTheSimulation) {
  std::mt19937 random(1);
  const auto below = [&](size_t n) { return size_t(random() % n); };
  const char* paths[] = {"topologies/mesh/type",
                         "topologies/mesh/elements/shape",
                         "topologies/mesh/elements/shapes",
                         "topologies/mesh/elements/shape_map",
                         "topologies/mesh/elements/shape_map/tet",
                         "topologies/mesh/elements/offsets",
                         "topologies/mesh/elements/connectivity",
                         "topologies/mesh/elements/dims",
                         "topologies/mesh/elements/dims/k",
                         "coordsets/coords/type",
                         "coordsets/coords/values",
                         "coordsets/coords/values/x",
                         "fields/height/values",
                         "fields/ascent_ghosts/values",
                         "fields/ascent_ghosts/association"};
  const char* texts[] = {"unstructured", "structured", "rectilinear", "explicit", "mixed",
                         "hex",          "tet",        "vertex",      ""};
  const auto values = numbered(1000);
  const std::vector<int32_t> ghosts{0, 1, 0};
  size_t published = 0;
  for (int round = 0; round < sweep(10000); round++) {
    if (round % 10 == 0) {
      published += recorded().steps.size();
      ASSERT_EQ(initialize(), 0);
    }
    Mixed mixed;
    Curved curved;
    Surface& tree = below(2) != 0 ? static_cast<Surface&>(mixed) : curved;
    tree.step(round + 1);
    if (below(2) != 0) {
      tree.field("element", Surface::kSea + "/fields/ascent_ghosts");
      tree.external(Surface::kSea + "/fields/ascent_ghosts/values", ghosts.data(), &tree == &curved ? 2 : 3);
    }
    for (size_t changes = below(3); changes > 0; changes--) {
      const std::string path = Surface::kSea + "/" + paths[below(std::size(paths))];
      switch (below(5)) {
        case 0:
          tree.set(path, texts[below(std::size(texts))]);
          break;
        case 1:
          tree.set(path, int(below(12)) - 1);
          break;
        case 2:
          tree.external(path, values.data(), int64_t(below(30)), int64_t(4 * below(20)),
                        int64_t(4 * below(20)));
          break;
        case 3:
          tree.external(path, reinterpret_cast<const uint8_t*>(values.data()), 24 >> below(3),
                        int64_t(below(3)));
          break;
        default:
          tree.set(path, 1), tree.remove(path);
      }
    }
    const int status = execute(tree);
    ASSERT_TRUE(status == 0 || status == kWrong) << status;
  }
  EXPECT_GT(published, size_t(sweep(1000)));
}

}  // namespace
}  // namespace gxy::test
