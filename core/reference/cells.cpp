// SPDX-License-Identifier: Apache-2.0
#include "core/reference/cells.h"

#include <cmath>

namespace gxy::reference {

CellWalk::CellWalk(const Grid& grid, const Ray& ray)
    : cells_(grid.cells()),
      origin_((ray.origin - grid.origin) / grid.spacing),
      direction_(ray.direction / grid.spacing) {
  end_ = kInfinity;
  for (int a = 0; a < 3; a++) {
    if (direction_[a] == 0) {
      if (!(origin_[a] >= 0 && origin_[a] <= double(cells_[a]))) return;
      continue;
    }
    const double first = face(a, 0), second = face(a, cells_[a]);
    entry_ = std::max(entry_, std::min(first, second));
    end_ = std::min(end_, std::max(first, second));
  }
  if (!(entry_ < end_)) return;
  inside_ = true;
  start();
  findExit();
  if (!(exit_ > entry_)) advance();
}

/// Finds the first cell: an estimate, corrected by the faces.
void CellWalk::start() {
  for (int a = 0; a < 3; a++) {
    const double x = origin_[a] + entry_ * direction_[a];
    int64_t i = int64_t(std::floor(std::clamp(x, 0.0, double(cells_[a] - 1))));
    if (direction_[a] > 0) {
      while (i + 1 < cells_[a] && face(a, i + 1) <= entry_) i++;
      while (i > 0 && face(a, i) > entry_) i--;
    } else if (direction_[a] < 0) {
      while (i > 0 && face(a, i) <= entry_) i--;
      while (i + 1 < cells_[a] && face(a, i + 1) > entry_) i++;
    }
    cell_[a] = i;
  }
}

void CellWalk::findExit() {
  exit_ = end_;
  for (int a = 0; a < 3; a++) {
    if (direction_[a] != 0) exit_ = std::min(exit_, face(a, cell_[a] + (direction_[a] > 0)));
  }
}

void CellWalk::advance() {
  do {
    for (int a = 0; a < 3; a++) {
      if (direction_[a] == 0 || face(a, cell_[a] + (direction_[a] > 0)) > exit_) continue;
      cell_[a] += direction_[a] > 0 ? 1 : -1;
      if (cell_[a] < 0 || cell_[a] >= cells_[a]) inside_ = false;
    }
    if (!(exit_ < end_)) inside_ = false;
    if (!inside_) return;
    entry_ = std::max(entry_, exit_);
    findExit();
  } while (!(exit_ > entry_));
}

glm::dvec3 CellWalk::local(double t) const {
  glm::dvec3 w;
  for (int a = 0; a < 3; a++) {
    const bool moves = direction_[a] != 0;
    if (moves && t == face(a, cell_[a])) {
      w[a] = 0;
    } else if (moves && t == face(a, cell_[a] + 1)) {
      w[a] = 1;
    } else {
      const double x = moves ? origin_[a] + t * direction_[a] : origin_[a];
      w[a] = std::clamp(x - double(cell_[a]), 0.0, 1.0);
    }
  }
  return w;
}

Cubic alongRay(const CellCorners& c, glm::dvec3 p, glm::dvec3 q) {
  const double once =
      trilinear(c, {q.x, p.y, p.z}) + trilinear(c, {p.x, q.y, p.z}) + trilinear(c, {p.x, p.y, q.z});
  const double twice =
      trilinear(c, {p.x, q.y, q.z}) + trilinear(c, {q.x, p.y, q.z}) + trilinear(c, {q.x, q.y, p.z});
  return {{trilinear(c, p), once / 3, twice / 3, trilinear(c, q)}};
}

}  // namespace gxy::reference
