// SPDX-License-Identifier: Apache-2.0
#include "core/data/partitioning.h"

#include <cmath>

#include "core/comm/error.h"

namespace gxy {
namespace {

constexpr const char* kAxis[3] = {"x", "y", "z"};
constexpr double kMerge = 1e-9;  ///< fraction of the domain's side: coordinates closer than this are one face
constexpr double kMaxCells = 1 << 28;

size_t cellIndex(const std::array<int, 3>& n, int i, int j, int k) {
  return (size_t(k) * size_t(n[1]) + size_t(j)) * size_t(n[0]) + size_t(i);
}

void checkFaces(const std::array<std::vector<double>, 3>& faces) {
  for (int a = 0; a < 3; ++a) {
    const std::vector<double>& f = faces[a];
    const std::string where = std::string("partitioning: faces on axis ") + kAxis[a];
    if (f.size() < 2) throw Error(where + ": " + std::to_string(f.size()) + " given, expected 2 or more");
    for (size_t i = 0; i < f.size(); ++i) {
      if (!std::isfinite(f[i]) || (i > 0 && !(f[i - 1] < f[i]))) {
        throw Error(where + ": face " + std::to_string(i) + " is " + std::to_string(f[i]) +
                    ", expected finite coordinates in ascending order");
      }
    }
  }
}

/// The cells of one partition: the bounds of their indices, and their number.
struct CellBox {
  std::array<int, 3> first{INT32_MAX, INT32_MAX, INT32_MAX}, last{-1, -1, -1};
  int64_t count = 0;
};

/// Returns the sorted coordinates of all boxes on one axis, without those within kMerge of the last one kept.
std::vector<double> mergedFaces(std::span<const Box> boxes, int axis) {
  std::vector<double> all;
  for (const Box& b : boxes) {
    all.push_back(b.lo[axis]);
    all.push_back(b.hi[axis]);
  }
  std::sort(all.begin(), all.end());
  const double gap = kMerge * (all.back() - all.front());
  std::vector<double> faces{all.front()};
  for (double x : all) {
    if (x - faces.back() > gap) faces.push_back(x);
  }
  faces.back() = all.back();  // The domain's end keeps its exact coordinate.
  return faces;
}

int nearestFace(const std::vector<double>& faces, double x) {
  const auto above = std::lower_bound(faces.begin(), faces.end(), x);
  if (above == faces.end()) return int(faces.size()) - 1;
  const int i = int(above - faces.begin());
  return i > 0 && x - faces[i - 1] < faces[i] - x ? i - 1 : i;
}

std::string describe(const Box& b) {
  std::string text = "[";
  for (int a = 0; a < 3; ++a) {
    text += (a ? " x " : "") + std::to_string(b.lo[a]) + ".." + std::to_string(b.hi[a]);
  }
  return text + "]";
}

}  // namespace

Partitioning::Partitioning(std::array<std::vector<double>, 3> faces, std::vector<int32_t> cells,
                           std::vector<int32_t> owners)
    : faces_(std::move(faces)), cells_(std::move(cells)), owners_(std::move(owners)) {
  checkFaces(faces_);
  const std::array<int, 3> n = this->cells();
  const size_t expected = size_t(n[0]) * size_t(n[1]) * size_t(n[2]);
  if (cells_.size() != expected) {
    throw Error("partitioning: the table has " + std::to_string(cells_.size()) + " cells, expected " +
                std::to_string(expected));
  }
  for (size_t p = 0; p < owners_.size(); ++p) {
    if (owners_[p] < 0) {
      throw Error("partitioning: partition " + std::to_string(p) + " is owned by rank " +
                  std::to_string(owners_[p]) + ", expected 0 or more");
    }
  }
  std::vector<CellBox> parts(owners_.size());
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        const int32_t p = cells_[cellIndex(n, i, j, k)];
        if (p < 0 || size_t(p) >= parts.size()) {
          throw Error("partitioning: cell " + std::to_string(i) + ", " + std::to_string(j) + ", " +
                      std::to_string(k) + " belongs to partition " + std::to_string(p) + ", expected 0 to " +
                      std::to_string(int64_t(parts.size()) - 1));
        }
        CellBox& b = parts[p];
        const std::array<int, 3> c{i, j, k};
        for (int a = 0; a < 3; ++a) {
          b.first[a] = std::min(b.first[a], c[a]);
          b.last[a] = std::max(b.last[a], c[a]);
        }
        ++b.count;
      }
    }
  }
  for (size_t p = 0; p < parts.size(); ++p) {
    const CellBox& b = parts[p];
    int64_t size = b.count > 0 ? 1 : 0;
    for (int a = 0; a < 3; ++a) size *= b.last[a] - b.first[a] + 1;
    if (b.count == 0 || size != b.count) {
      throw Error("partitioning: partition " + std::to_string(p) + " has " + std::to_string(b.count) +
                  " lattice cells, expected a non-empty box of cells");
    }
    Box box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = faces_[a][b.first[a]];
      box.hi[a] = faces_[a][b.last[a] + 1];
    }
    boxes_.push_back(box);
  }
  for (int a = 0; a < 3; ++a) {
    domain_.lo[a] = faces_[a].front();
    domain_.hi[a] = faces_[a].back();
  }
}

Partitioning Partitioning::lattice(std::array<std::vector<double>, 3> faces, int ranks) {
  if (ranks < 1) throw Error("partitioning: " + std::to_string(ranks) + " ranks, expected 1 or more");
  checkFaces(faces);
  size_t parts = 1;
  for (const auto& f : faces) parts *= f.size() - 1;
  if (parts > size_t(INT32_MAX)) {
    throw Error("partitioning: " + std::to_string(parts) + " partitions, expected fewer than 2^31");
  }
  std::vector<int32_t> cells(parts), owners(parts);
  for (size_t p = 0; p < parts; ++p) {
    cells[p] = int32_t(p);
    owners[p] = int32_t(int64_t(p) * ranks / int64_t(parts));
  }
  return Partitioning(std::move(faces), std::move(cells), std::move(owners));
}

Partitioning Partitioning::fromBoxes(std::span<const Box> boxes, std::vector<int32_t> owners) {
  if (boxes.empty()) throw Error("partitioning: no boxes given, expected 1 or more");
  if (boxes.size() != owners.size()) {
    throw Error("partitioning: " + std::to_string(boxes.size()) + " boxes and " +
                std::to_string(owners.size()) + " owners, expected as many");
  }
  for (size_t p = 0; p < boxes.size(); ++p) {
    for (int a = 0; a < 3; ++a) {
      if (!std::isfinite(boxes[p].lo[a]) || !std::isfinite(boxes[p].hi[a]) ||
          !(boxes[p].lo[a] < boxes[p].hi[a])) {
        throw Error("partitioning: box " + std::to_string(p) + " " + describe(boxes[p]) +
                    ", expected finite corners and a positive size");
      }
    }
  }
  std::array<std::vector<double>, 3> faces;
  std::array<int, 3> n;
  for (int a = 0; a < 3; ++a) {
    faces[a] = mergedFaces(boxes, a);
    n[a] = int(faces[a].size()) - 1;
  }
  if (double(n[0]) * n[1] * n[2] > kMaxCells) {
    throw Error("partitioning: the faces of " + std::to_string(boxes.size()) + " boxes make " +
                std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]) +
                " lattice cells, expected 2^28 or fewer");
  }
  std::vector<int32_t> cells(size_t(n[0]) * size_t(n[1]) * size_t(n[2]), -1);
  for (size_t p = 0; p < boxes.size(); ++p) {
    std::array<int, 3> lo, hi;
    for (int a = 0; a < 3; ++a) {
      lo[a] = nearestFace(faces[a], boxes[p].lo[a]);
      hi[a] = nearestFace(faces[a], boxes[p].hi[a]);
    }
    for (int k = lo[2]; k < hi[2]; ++k) {
      for (int j = lo[1]; j < hi[1]; ++j) {
        for (int i = lo[0]; i < hi[0]; ++i) {
          int32_t& cell = cells[cellIndex(n, i, j, k)];
          if (cell >= 0) {
            throw Error("partitioning: box " + std::to_string(cell) + " " + describe(boxes[cell]) +
                        " and box " + std::to_string(p) + " " + describe(boxes[p]) +
                        " overlap, expected disjoint boxes");
          }
          cell = int32_t(p);
        }
      }
    }
  }
  const auto hole = std::find(cells.begin(), cells.end(), -1);
  if (hole != cells.end()) {
    const int64_t c = hole - cells.begin();
    const std::array<int64_t, 3> at{c % n[0], c / n[0] % n[1], c / n[0] / n[1]};
    Box gap;
    for (int a = 0; a < 3; ++a) {
      gap.lo[a] = faces[a][at[a]];
      gap.hi[a] = faces[a][at[a] + 1];
    }
    throw Error("partitioning: no box holds " + describe(gap) + ", expected boxes that fill the domain");
  }
  return Partitioning(std::move(faces), std::move(cells), std::move(owners));
}

Partitioning Partitioning::single(const Box& box) { return fromBoxes(std::span(&box, 1), {0}); }

std::vector<int> Partitioning::owned(int rank) const {
  std::vector<int> parts;
  for (int p = 0; p < partitions(); ++p) {
    if (owners_[p] == rank) parts.push_back(p);
  }
  return parts;
}

std::array<int, 3> Partitioning::cells() const {
  return {int(faces_[0].size()) - 1, int(faces_[1].size()) - 1, int(faces_[2].size()) - 1};
}

int Partitioning::locate(glm::dvec3 p) const {
  std::array<int, 3> c;
  for (int a = 0; a < 3; ++a) {
    const std::vector<double>& f = faces_[a];
    if (!(p[a] >= f.front() && p[a] <= f.back())) return -1;
    const int above = int(std::upper_bound(f.begin(), f.end(), p[a]) - f.begin());
    c[a] = std::min(above - 1, int(f.size()) - 2);
  }
  return cells_[cellIndex(cells(), c[0], c[1], c[2])];
}

int Partitioning::nearest(glm::dvec3 p) const {
  for (int a = 0; a < 3; ++a) p[a] = std::clamp(p[a], domain_.lo[a], domain_.hi[a]);
  return locate(p);
}

std::array<int, 2> Partitioning::cellsTouched(int axis, double lo, double hi) const {
  // Only inner faces count, since points beyond the domain's ends belong to the outermost cells.
  const auto begin = faces_[axis].begin() + 1, end = faces_[axis].end() - 1;
  return {int(std::lower_bound(begin, end, lo) - begin), int(std::upper_bound(begin, end, hi) - begin)};
}

}  // namespace gxy
