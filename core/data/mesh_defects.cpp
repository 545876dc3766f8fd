// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace gxy {

namespace {

/// A face as a plane: that of a triangle, or the one through the middle of a quad along both of its diagonals.
struct FacePlane {
  glm::dvec3 point, normal;
  int sideOf(const glm::dvec3& p) const {
    const double distance = glm::dot(normal, p - point);
    return int(distance > 0) - int(distance < 0);
  }
};

FacePlane planeOf(const MeshBlock& block, const CellFace& face, std::span<const uint32_t> cell) {
  std::array<glm::dvec3, 4> p{};
  for (size_t k = 0; k < face.corners; k++) p[k] = block.points[cell[face.corner[k]]];
  if (face.corners == 3) return {p[0], glm::cross(p[1] - p[0], p[2] - p[0])};
  return {(p[0] + p[1] + p[2] + p[3]) * 0.25, glm::cross(p[2] - p[0], p[3] - p[1])};
}

/// The middle of a cell's points that do not belong to a face. It is on the same side of the face as the middle of the cell.
glm::dvec3 middleBeside(const MeshBlock& block, FaceId id) {
  const auto cell = block.cells.pointsOf(cellOf(id));
  const CellFace& face = shapeOf(block.cells.typeOf(cellOf(id))).face[size_t(faceOf(id))];
  glm::dvec3 sum(0);
  for (size_t i = 0; i < cell.size(); i++)
    if (std::find(face.corner.begin(), face.corner.begin() + face.corners, i) ==
        face.corner.begin() + face.corners)
      sum += block.points[cell[i]];
  return sum / double(cell.size() - face.corners);
}

uint64_t countFoldedFaces(const MeshBlock& block, std::span<const uint8_t> isHere) {
  uint64_t folded = 0;
  for (const CellType type : kAllCellTypes) {
    const CellShape& shape = shapeOf(type);
    const uint32_t first = block.cells.first(type);
    const std::span<const FaceId> neighbours = block.neighbours[size_t(type)];
    const std::span<const uint32_t> cells = block.cells.points[size_t(type)];
    for (size_t i = 0; i < neighbours.size(); i++) {
      const size_t cell = i / shape.faces, f = i % shape.faces;
      const FaceId id = faceId(first + uint32_t(cell), int(f)), other = neighbours[i];
      if (other == kNoFace || other < id) continue;
      const auto points = cells.subspan(cell * shape.points, shape.points);
      uint32_t lowest = points[shape.face[f].corner[0]];
      for (size_t k = 1; k < shape.face[f].corners; k++)
        lowest = std::min(lowest, points[shape.face[f].corner[k]]);
      if (!isHere[lowest]) continue;
      const FacePlane plane = planeOf(block, shape.face[f], points);
      folded += plane.sideOf(middleBeside(block, id)) * plane.sideOf(middleBeside(block, other)) >= 0;
    }
  }
  return folded;
}

/// A face of the shell: its points, the first three of them if it is a triangle.
struct ShellFace {
  std::array<uint32_t, 4> points{};
  uint32_t corners = 0;

  bool has(uint32_t point) const {
    return std::find(points.begin(), points.begin() + corners, point) != points.begin() + corners;
  }
  uint32_t lowest() const { return *std::min_element(points.begin(), points.begin() + corners); }
};

ShellFace shellFace(const MeshBlock& block, FaceId id) {
  const auto cell = block.cells.pointsOf(cellOf(id));
  const CellFace& face = shapeOf(block.cells.typeOf(cellOf(id))).face[size_t(faceOf(id))];
  ShellFace shell;
  for (size_t k = 0; k < face.corners; k++) {
    const uint32_t point = cell[face.corner[k]];
    if (!shell.has(point)) shell.points[shell.corners++] = point;
  }
  return shell;
}

/// How near, as a part of its longest edge, a point must be to a face to lie in it.
constexpr double kNear = 1e-6;

struct CornersOfFace {
  std::array<glm::dvec3, 4> p{};
  uint32_t corners = 0;
  double near = 0;
};

CornersOfFace cornersOf(const MeshBlock& block, const ShellFace& face) {
  CornersOfFace f;
  f.corners = face.corners;
  for (uint32_t k = 0; k < face.corners; k++) f.p[k] = block.points[face.points[k]];
  for (uint32_t k = 0; k < face.corners; k++)
    f.near = std::max(f.near, kNear * glm::distance(f.p[k], f.p[(k + 1) % face.corners]));
  return f;
}

/// Solves u a + v b = r by least squares; false if a and b are parallel.
bool solve(glm::dvec3 a, glm::dvec3 b, glm::dvec3 r, double& u, double& v) {
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
  const double det = aa * bb - ab * ab;
  if (!(det > 1e-14 * aa * bb)) return false;
  const double ar = glm::dot(a, r), br = glm::dot(b, r);
  u = (bb * ar - ab * br) / det;
  v = (aa * br - ab * ar) / det;
  return true;
}

/// Whether a point lies in a triangle or in a bilinear quad.
bool liesIn(const CornersOfFace& f, glm::dvec3 point) {
  double u = 0.5, v = 0.5;
  if (f.corners == 3) {
    const glm::dvec3 a = f.p[1] - f.p[0], b = f.p[2] - f.p[0], r = point - f.p[0];
    if (!solve(a, b, r, u, v)) return false;
    return std::min({u, v, 1 - u - v}) >= -kNear && glm::length(r - u * a - v * b) <= f.near;
  }
  const auto place = [&](double x, double y) {
    return (1 - y) * ((1 - x) * f.p[0] + x * f.p[1]) + y * ((1 - x) * f.p[3] + x * f.p[2]);
  };
  constexpr int kSteps = 12;
  for (int step = 0; step < kSteps; step++) {
    const glm::dvec3 a = (1 - v) * (f.p[1] - f.p[0]) + v * (f.p[2] - f.p[3]),
                     b = (1 - u) * (f.p[3] - f.p[0]) + u * (f.p[2] - f.p[1]);
    double du = 0, dv = 0;
    if (!solve(a, b, point - place(u, v), du, dv)) return false;
    u = std::clamp(u + du, 0.0, 1.0);
    v = std::clamp(v + dv, 0.0, 1.0);
  }
  return glm::distance(place(u, v), point) <= f.near;
}

/// The boxes of faces in runs, of runs in runs, and so on. Faces that follow each other are near each other, as cells are in the order of
/// Morton's curve.
class FaceBoxes {
 public:
  explicit FaceBoxes(std::vector<Box> boxes) {
    levels_.push_back(std::move(boxes));
    while (levels_.back().size() > 1) {
      const std::vector<Box>& below = levels_.back();
      std::vector<Box> level((below.size() + kRun - 1) / kRun);
      for (size_t i = 0; i < below.size(); i++) {
        level[i / kRun].extend(below[i].lo);
        level[i / kRun].extend(below[i].hi);
      }
      levels_.push_back(std::move(level));
    }
  }

  /// Calls visit(face) for the faces in whose boxes a point is, until it returns true, and returns whether it has.
  template <class Visit>
  bool any(const glm::dvec3& point, const Visit& visit) const {
    return anyOf(levels_.size() - 1, 0, point, visit);
  }

 private:
  static constexpr size_t kRun = 8;

  template <class Visit>
  bool anyOf(size_t level, size_t i, const glm::dvec3& point, const Visit& visit) const {
    if (i >= levels_[level].size() || !levels_[level][i].overlaps({point, point})) return false;
    if (level == 0) return visit(i);
    for (size_t k = 0; k < kRun; k++)
      if (anyOf(level - 1, i * kRun + k, point, visit)) return true;
    return false;
  }

  std::vector<std::vector<Box>> levels_;
};

uint64_t countHangingPoints(const MeshBlock& block, std::span<const ShellFace> shell,
                            std::span<const uint8_t> isHere) {
  std::vector<Box> boxes;
  std::vector<uint8_t> onShell(block.points.size(), 0);
  for (const ShellFace& face : shell) {
    const CornersOfFace f = cornersOf(block, face);
    Box box;
    for (uint32_t k = 0; k < face.corners; k++) {
      box.extend(f.p[k] - f.near);
      box.extend(f.p[k] + f.near);
      onShell[face.points[k]] = 1;
    }
    boxes.push_back(box);
  }
  const FaceBoxes tree(std::move(boxes));
  uint64_t hanging = 0;
  for (uint32_t p = 0; p < block.points.size(); p++)
    hanging += onShell[p] && isHere[p] && tree.any(block.points[p], [&](size_t i) {
      return !shell[i].has(p) && liesIn(cornersOf(block, shell[i]), block.points[p]);
    });
  return hanging;
}

/// Quads are few where triangles are many, and the other way round; so the quads of each point are listed.
uint64_t countSplitFaces(const MeshBlock& block, std::span<const ShellFace> shell,
                         std::span<const uint8_t> isHere) {
  std::vector<uint32_t> first(block.points.size() + 1, 0);
  for (const ShellFace& face : shell)
    for (uint32_t k = 0; face.corners == 4 && k < 4; k++) first[face.points[k] + 1]++;
  for (size_t p = 0; p < block.points.size(); p++) first[p + 1] += first[p];
  std::vector<uint32_t> quads(first.back()), next(first.begin(), first.end() - 1);
  for (uint32_t i = 0; i < shell.size(); i++)
    for (uint32_t k = 0; shell[i].corners == 4 && k < 4; k++) quads[next[shell[i].points[k]]++] = i;
  uint64_t split = 0;
  for (const ShellFace& face : shell) {
    if (face.corners != 3 || !isHere[face.lowest()]) continue;
    const auto at = quads.begin() + std::ptrdiff_t(first[face.points[0]]),
               end = quads.begin() + std::ptrdiff_t(first[face.points[0] + 1]);
    split += std::any_of(at, end, [&](uint32_t quad) {
      return shell[quad].has(face.points[1]) && shell[quad].has(face.points[2]);
    });
  }
  return split;
}

}  // namespace

bool isInverted(std::span<const glm::dvec3> points, CellType type, std::span<const uint32_t> cell) {
  const auto from = [&](uint8_t corner) { return points[cell[corner]] - points[cell[0]]; };
  if (type == CellType::Tetrahedron) return glm::dot(glm::cross(from(1), from(2)), from(3)) < 0;
  double volume = 0;
  const CellShape& shape = shapeOf(type);
  for (size_t f = 0; f < shape.faces; f++) {
    const CellFace& face = shape.face[f];
    glm::dvec3 middle(0);
    for (size_t k = 0; k < face.corners; k++) middle += from(face.corner[k]);
    middle /= double(face.corners);
    for (size_t k = 0; k < face.corners; k++)
      volume += glm::dot(middle, glm::cross(from(face.corner[k]), from(face.corner[(k + 1) % face.corners])));
  }
  return volume < 0;
}

MeshDefects defectsOf(const MeshBlock& block, std::span<const uint8_t> isHere) {
  std::vector<ShellFace> shell;
  shell.reserve(block.shell.size());
  for (const FaceId id : block.shell) shell.push_back(shellFace(block, id));
  MeshDefects defects;
  defects.foldedFaces = countFoldedFaces(block, isHere);
  if (!shell.empty()) {
    defects.hangingPoints = countHangingPoints(block, shell, isHere);
    defects.splitFaces = countSplitFaces(block, shell, isHere);
  }
  return defects;
}

}  // namespace gxy
