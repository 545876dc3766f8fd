// SPDX-License-Identifier: Apache-2.0
// The field of hexahedra, wedges and pyramids along rays.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/reference/cell_samples.h"

namespace gxy::reference {
namespace {

double chordInCube(const Ray& ray) {
  double in = 0, out = kInfinity;
  for (int a = 0; a < 3; a++) {
    const double s = -ray.origin[a] / ray.direction[a], e = (1 - ray.origin[a]) / ray.direction[a];
    in = std::max(in, std::min(s, e)), out = std::min(out, std::max(s, e));
  }
  return std::max(0.0, out - in);
}

/// Exact in float at all points that inside() makes.
double linearHere(glm::dvec3 p) { return 0.125 + 0.5 * p.x + 0.25 * p.y - 0.125 * p.z; }

/// Expects spans that follow each other without gaps or overlaps. Where a ray meets several faces at once, spans may be as long as the
/// slack.
void expectUnbroken(std::vector<MeshSpan> spans, double slack = 0) {
  std::erase_if(spans, [&](const MeshSpan& s) { return s.t1 - s.t0 < slack; });
  for (size_t k = 1; k < spans.size(); k++) ASSERT_NEAR(spans[k - 1].t1, spans[k].t0, slack) << k;
}

TEST(CellReference, ChordsOfBentCellsAddUpToThoseOfTheCube) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field(*meshOf(filling.make(5, inside(0.04, 1), kOne)), std::nullopt);
    Uniform random(5);
    for (int i = 0; i < 1000; i++) {
      const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
      if (ray.origin == glm::clamp(ray.origin, 0.0, 1.0)) continue;
      const auto spans = field.along(ray, {});
      ASSERT_NEAR(lengthOf(spans), chordInCube(ray), 1e-13) << filling.name;
      expectUnbroken(spans);
    }
  }
}

TEST(CellReference, RaysThroughVerticesEdgesAndFacesMeetEachStretchOnce) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field(*meshOf(filling.make(4, kStill, kOne)), std::nullopt);
    int met = 0;
    for (int dx = -2; dx <= 2; dx++)
      for (int dy = -2; dy <= 2; dy++)
        for (int dz = -2; dz <= 2; dz++) {
          const glm::dvec3 d(dx, dy, dz);
          if (d == glm::dvec3(0)) continue;
          for (int i = 1; i < 8; i++) {
            const glm::dvec3 at = glm::dvec3(i, 3 * i % 8, 5 * i % 8) / 8.0;
            if (std::min({at.x, at.y, at.z}) == 0) continue;
            const Ray ray{at - 8.0 * d, glm::normalize(d)};
            const auto spans = field.along(ray, {});
            ASSERT_NEAR(lengthOf(spans), chordInCube(ray), 1e-12) << filling.name;
            expectUnbroken(spans, 1e-12);
            met++;
          }
        }
    EXPECT_GT(met, 500);
  }
}

TEST(CellReference, RaysThroughPointsOfBentCellsMeetEachStretchOnce) {
  for (const CellFilling& filling : kFillings) {
    const MeshPiece piece = filling.make(4, inside(0.04, 3), kOne);
    const MeshField field(*meshOf(piece), std::nullopt);
    Uniform random(6);
    const auto anyPoint = [&] { return piece.points[size_t(random() * double(piece.points.size()))]; };
    for (int i = 0; i < 1000; i++) {
      const glm::dvec3 one = anyPoint(), other = anyPoint();
      if (one == other) continue;
      Ray ray = towards(one, other);
      ray.origin -= 2.0 * ray.direction;
      bool inBorder = false;  // a ray in the border is moved into the cube or out of it
      for (int a = 0; a < 3; a++) inBorder = inBorder || (one[a] == other[a] && (one[a] == 0 || one[a] == 1));
      if (inBorder) continue;
      const auto spans = field.along(ray, {});
      ASSERT_NEAR(lengthOf(spans), chordInCube(ray), 1e-12) << filling.name;
      expectUnbroken(spans, 1e-12);
    }
  }
}

TEST(CellReference, LinearFieldsAreExactInCellsThatAreBentByUpToAThird) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field(*meshOf(filling.make(4, inside(0.075, 2), linearHere)), std::nullopt);
    Uniform random(4);
    size_t checked = 0;
    for (int i = 0; i < 500; i++) {
      const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
      for (const MeshSpan& s : field.along(ray, {}))
        for (const double w : {0.0, 0.2, 0.5, 0.9, 1.0}) {
          ASSERT_NEAR(s.value.value(w), linearHere(ray.at(mix(s.t0, s.t1, w))), 1e-12) << filling.name;
          checked++;
        }
    }
    EXPECT_GT(checked, 5000u);
  }
}

// The places and values of VTK's shape functions, forwards.
TEST(CellReference, ValuesAreThoseOfTheShapeFunctions) {
  for (const CellType type : {CellType::Pyramid, CellType::Wedge, CellType::Hexahedron}) {
    Uniform random(31);
    for (int i = 0; i < 400; i++) {
      const MeshPiece piece = oneBentCell(type, i < 100 ? 0 : 0.12, random);
      const MeshField field(*meshOf(piece), std::nullopt);
      const auto weights = vtkShape(type, randomPlace(type, random));
      glm::dvec3 at(0);
      double value = 0;
      for (size_t k = 0; k < piece.points.size(); k++)
        at += weights[k] * piece.points[k], value += weights[k] * double(piece.values[k]);
      const Ray ray = towards(at + 3.0 * glm::normalize(random.inCube(1)), at);
      const double t = glm::dot(at - ray.origin, ray.direction);
      int found = 0;
      for (const MeshSpan& s : field.along(ray, {})) {
        if (!(s.t0 <= t && t < s.t1)) continue;
        EXPECT_NEAR(s.value.value((t - s.t0) / (s.t1 - s.t0)), value, 1e-7) << int(type);
        found++;
      }
      EXPECT_EQ(found, 1) << int(type);
    }
  }
}

TEST(CellReference, ATrilinearFunctionOnStraightHexahedraIsItselfInOneCubicACell) {
  const auto f = [](glm::dvec3 p) { return (1 - 2 * p.x) * (0.5 + p.y) * (1 - 0.25 * p.z) + p.x * p.z; };
  const MeshField field(*meshOf(test::cubeOfHexes(4, kStill, f)), std::nullopt);
  Uniform random(9);
  for (int i = 0; i < 300; i++) {
    const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
    for (const MeshSpan& s : field.along(ray, {})) {
      for (const double w : {0.0, 0.3, 0.5, 0.8, 1.0})
        EXPECT_NEAR(s.value.value(w), f(ray.at(mix(s.t0, s.t1, w))), 3e-14);
      const glm::dvec3 middle = 4.0 * ray.at(0.5 * (s.t0 + s.t1));
      const glm::dvec3 in = 4.0 * ray.at(mix(s.t0, s.t1, 1e-6)),
                       out = 4.0 * ray.at(mix(s.t0, s.t1, 1 - 1e-6));
      EXPECT_EQ(glm::floor(in), glm::floor(middle));
      EXPECT_EQ(glm::floor(out), glm::floor(middle));
    }
  }
}

TEST(CellReference, CubicsAgreeWithTheMapInsideBentCells) {
  for (const CellType type : {CellType::Pyramid, CellType::Wedge, CellType::Hexahedron}) {
    Uniform random(12);
    size_t several = 0;
    for (int i = 0; i < 200; i++) {
      const MeshPiece piece = oneBentCell(type, 0.2, random);
      const MeshField field(*meshOf(piece), std::nullopt);
      OfCorners values{};
      std::copy(piece.values.begin(), piece.values.end(), values.begin());
      const Ray ray = towards(glm::dvec3(0.4) + 3.0 * glm::normalize(random.inCube(1)),
                              glm::dvec3(0.4) + random.inCube(0.2));
      const auto spans = field.along(ray, {});
      several += spans.size() > 1;
      for (const MeshSpan& s : spans) {
        const double w = random();
        const auto inverse =
            invert(type, piece.points, ray.at(mix(s.t0, s.t1, w)), glm::dvec3(0.4, 0.4, 0.5));
        if (inverse) {
          EXPECT_NEAR(s.value.value(w), shapeAt(type, inverse->place).mean(values), 1e-7);
        }
      }
    }
    EXPECT_GT(several, 50u);
  }
}

TEST(CellReference, ARayInARulingOfABentFaceMeetsEachStretchOnce) {
  // two hexahedra, between which is the surface z = 0.25 + 0.5 x y
  MeshPiece piece;
  for (const int layer : {0, 1, 2})
    for (const glm::dvec3 p : {glm::dvec3(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}) {
      piece.points.push_back({p.x, p.y, layer == 0 ? 0 : layer == 2 ? 1 : 0.25 + 0.5 * p.x * p.y});
      piece.values.push_back(1);
    }
  auto& hexes = piece.cells.points[size_t(CellType::Hexahedron)];
  hexes = {0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 8, 9, 10, 11};
  const MeshField field(*meshOf(piece), std::nullopt);
  for (const double x : {0.125, 0.25, 0.5, 0.625, 0.875}) {
    for (const bool swapped : {false, true}) {
      const auto turned = [&](double a, double b, double c) {
        return swapped ? glm::dvec3(b, a, c) : glm::dvec3(a, b, c);
      };
      const Ray ray = towards(turned(x, -1, 0.25 - 0.5 * x), turned(x, 2, 0.25 + x));
      const auto spans = field.along(ray, {});
      EXPECT_NEAR(lengthOf(spans), chordInCube(ray), 1e-14);
      expectUnbroken(spans, 1e-14);
    }
  }
}

TEST(CellReference, InvertedCellsAreTheSameAsTheirMirrorImages) {
  Uniform random(3);
  const MeshPiece one = oneBentCell(CellType::Hexahedron, 0.15, random);
  MeshPiece other = one;
  other.cells.points[size_t(CellType::Hexahedron)] = {4, 5, 6, 7, 0, 1, 2, 3};
  for (int i = 0; i < 100; i++) {
    const Ray ray = towards(glm::dvec3(3, 2, 1) + random.inCube(1), glm::dvec3(0.5) + random.inCube(0.5));
    const auto a = MeshField(*meshOf(one), std::nullopt).along(ray, {}),
               b = MeshField(*meshOf(other), std::nullopt).along(ray, {});
    ASSERT_EQ(a.size(), b.size());
    for (size_t k = 0; k < a.size(); k++) {
      EXPECT_EQ(a[k].t0, b[k].t0);
      EXPECT_NEAR(a[k].value.value(0.3), b[k].value.value(0.3), 1e-12);
    }
  }
}

TEST(CellReference, CellsWithAPointWithoutDataAreTransparent) {
  for (const CellFilling& filling : kFillings) {
    MeshPiece piece = filling.make(2, kStill, kOne);
    piece.values[13] = std::numeric_limits<float>::quiet_NaN();  // the middle
    const MeshField field(*meshOf(piece), std::nullopt);
    EXPECT_GT(meshOf(piece)->blocks[0].cells.size(), field.cells());
    EXPECT_TRUE(field.along(towards({0.5, 0.5, -1}, {0.5, 0.5, 0.5}), {}).empty()) << filling.name;
  }
}

TEST(CellReference, CellsThatSeveralBlocksHaveCountOnce) {
  for (const CellFilling& filling : kFillings) {
    const MeshPiece whole = filling.make(3, inside(0.05, 2), [](glm::dvec3 p) { return p.x; });
    auto cut = meshOf(whole);
    cut->blocks.clear();
    const auto last = uint32_t(whole.points.size()) - 1;
    for (int part = 0; part < 3; part++) {
      // each has two thirds of the cells, with the points numbered the other way round
      MeshBlock& block = cut->blocks[part];
      block.points = std::vector<glm::dvec3>(whole.points.rbegin(), whole.points.rend());
      block.values.assign(whole.values.rbegin(), whole.values.rend());
      for (const CellType type : kAllCellTypes) {
        const auto& cells = whole.cells.points[size_t(type)];
        const size_t n = shapeOf(type).points;
        std::vector<uint32_t> some;
        for (size_t i = 0; i < cells.size(); i += n)
          if (i / n % 3 != size_t(part))
            for (size_t k = 0; k < n; k++) some.push_back(last - cells[i + k]);
        block.cells.points[size_t(type)] = std::move(some);
      }
    }
    const MeshField one(*meshOf(whole), std::nullopt), several(*cut, std::nullopt);
    EXPECT_EQ(several.cells(), one.cells());
    Uniform random(8);
    for (int i = 0; i < 100; i++) {
      const Ray ray = towards({-1, 0.2, 2}, 0.5 + random.inCube(0.5));
      EXPECT_NEAR(lengthOf(several.along(ray, {})), lengthOf(one.along(ray, {})), 1e-13) << filling.name;
    }
  }
}

// Wedges and pyramids are hexahedra with points that are the same.
TEST(CellReference, CollapsedHexahedraAreWedgesAndPyramids) {
  const auto compare = [](CellType type, const std::array<uint32_t, 8>& collapsed) {
    Uniform random(41);
    for (int i = 0; i < 50; i++) {
      const MeshPiece cell = oneBentCell(type, 0.1, random);
      MeshPiece hexahedron = cell;
      hexahedron.cells = {};
      hexahedron.cells.points[size_t(CellType::Hexahedron)].assign(collapsed.begin(), collapsed.end());
      const MeshField one(*meshOf(cell), std::nullopt), other(*meshOf(hexahedron), std::nullopt);
      const Ray ray = towards(glm::dvec3(0.4) + 3.0 * glm::normalize(random.inCube(1)),
                              glm::dvec3(0.35) + random.inCube(0.1));
      const auto a = one.along(ray, {}), b = other.along(ray, {});
      ASSERT_FALSE(a.empty());
      ASSERT_FALSE(b.empty());
      EXPECT_NEAR(a.front().t0, b.front().t0, 1e-12);
      EXPECT_NEAR(a.back().t1, b.back().t1, 1e-12);
      for (const MeshSpan& s : a)
        for (const MeshSpan& o : b) {
          const double t = 0.5 * (std::max(s.t0, o.t0) + std::min(s.t1, o.t1));
          if (!(t > std::max(s.t0, o.t0) && t < std::min(s.t1, o.t1))) continue;
          EXPECT_NEAR(s.value.value((t - s.t0) / (s.t1 - s.t0)), o.value.value((t - o.t0) / (o.t1 - o.t0)),
                      2e-7);
        }
    }
  };
  compare(CellType::Wedge, {0, 1, 2, 2, 3, 4, 5, 5});
  compare(CellType::Pyramid, {0, 1, 2, 3, 4, 4, 4, 4});
}

TEST(CellReference, SliversHaveTheirThinChordAndFlatCellsHaveNone) {
  for (const double h : {1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
    MeshPiece piece = test::cubeOfHexes(1, kStill, [](glm::dvec3 p) { return p.x + p.z; });
    for (glm::dvec3& p : piece.points) p.z *= h * (1 + 0.25 * p.x * p.y);
    const MeshField field(*meshOf(piece), std::nullopt);
    Uniform random(2);
    for (int i = 0; i < 100; i++) {
      const glm::dvec3 at(random(), random(), 0);
      const Ray ray{at + glm::dvec3(0, 0, 2), {0, 0, -1}};
      const auto spans = field.along(ray, {});
      EXPECT_NEAR(lengthOf(spans), h * (1 + 0.25 * at.x * at.y), 1e-15);
      for (const MeshSpan& s : spans)
        for (const double w : {0.1, 0.5, 0.9}) {
          const double depth = (2 - mix(s.t0, s.t1, w)) / (1 + 0.25 * at.x * at.y);
          if (h > 1e-11) {
            EXPECT_NEAR(s.value.value(w), at.x + depth / h, 1e-7 + 4e-15 / h);
          }
        }
      const auto aslant = field.along(towards({3, 2, 1}, at), {});
      EXPECT_LE(lengthOf(aslant), 10 * h + 1e-14);
    }
  }
}

TEST(CellReference, TangledCellsHaveFiniteSpans) {
  for (const CellFilling& filling : kFillings)
    for (const double far : {0.2, 0.4}) {
      const MeshField field(*meshOf(filling.make(4, inside(far, 2), linearHere)), std::nullopt);
      const MeshSurface surface = field.isosurface(0.4);
      Uniform random(4);
      double length = 0;
      for (int i = 0; i < 100; i++) {
        const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
        for (const MeshSpan& s : field.along(ray, {})) {
          EXPECT_LT(s.t0, s.t1);
          length += s.t1 - s.t0;
          for (const double b : s.value.b) EXPECT_LE(std::abs(b - 0.4), 0.6);
        }
        for (const MeshCrossing& hit : surface.along(ray)) EXPECT_NEAR(hit.value, 0.4, 1e-9) << filling.name;
      }
      EXPECT_GT(length, 70);
    }
}

}  // namespace
}  // namespace gxy::reference
