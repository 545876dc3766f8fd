// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/geometry_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <string>

#include "backends/bvh/tree.h"
#include "backends/embree/tree_layout.h"
#include "core/kernels/single_views.h"

namespace gxy {

namespace {

int rowsOf(int kind) {
  return kind == KIND_PARTICLES   ? TREE_SPHERE_ROWS
         : kind == KIND_PATHLINES ? TREE_TUBE_ROWS
         : kind == KIND_MESH      ? TREE_CELL_ROWS
         : kind == KIND_SHELL     ? TREE_SHELL_ROWS
         : kind == KIND_HEX_MESH  ? TREE_HEX_CELL_ROWS
         : kind == KIND_HEX_SHELL ? TREE_HEX_SHELL_ROWS
                                  : TREE_TRIANGLE_ROWS;
}

// Returns the numbers of one primitive, one for each row of a leaf.
std::array<float, TREE_MOST_ROWS> rowsOf(int kind, const GeometryInPartition& part, uint32_t primitive) {
  std::array<float, TREE_MOST_ROWS> rows{};
  const auto copy = [&](uint32_t point, size_t numbers, size_t row) {
    std::copy_n(part.arrays().points.data() + 4 * size_t(point), numbers, rows.data() + row);
  };
  if (kind == KIND_PARTICLES) {
    copy(primitive, 4, 0);
  } else if (kind == KIND_PATHLINES) {
    const uint32_t* ends = part.indices.data() + 2 * size_t(primitive);
    const uint32_t* near = part.neighbours.empty() ? ends : part.neighbours.data() + 2 * size_t(primitive);
    for (size_t k = 0; k < 2; k++) {
      copy(ends[k], 4, 4 * k);
      copy(near[k], 4, 8 + 4 * k);
      rows[16 + k] = near[k] != ends[k];
    }
  } else if (kind == KIND_MESH) {
    std::copy_n(part.points.data() + 16 * size_t(primitive), 16, rows.data());
  } else if (kind == KIND_SHELL) {
    const FaceId face = part.shell[primitive];
    size_t row = 0;
    for (int k = 0; k < 4; k++)
      if (k != faceOf(face)) copy(part.arrays().indices[4 * size_t(cellOf(face)) + size_t(k)], 3, 3 * row++);
    rows[9] = std::bit_cast<float>(face);
  } else if (kind == KIND_HEX_MESH) {
    std::copy_n(part.points.data() + 32 * size_t(primitive), 32, rows.data());
    rows[32] = std::bit_cast<float>(part.orders[primitive]);
  } else if (kind == KIND_HEX_SHELL) {
    const FaceId face = part.shell[primitive];
    const auto side = uint32_t(faceOf(face)), orders = part.arrays().orders[cellOf(face)];
    const uint32_t corners = single::orderedCorners(side, orders);
    for (size_t k = 0; k < 4; k++)
      copy(part.arrays().indices[8 * size_t(cellOf(face)) + (corners >> 4 * k & 7)], 3, 3 * k);
    rows[12] = std::bit_cast<float>(face);
    rows[13] = single::isTriangle(side, orders) ? 1.0f : 0.0f;
  } else {
    for (size_t k = 0; k < 3; k++) copy(part.indices[3 * size_t(primitive) + k], 3, 3 * k);
  }
  return rows;
}

// Writes a tree into arrays, depth first, in the order in which rays walk it.
template <size_t Lanes>
class Flatten {
 public:
  using Tree = embree::Tree<unsigned(Lanes), unsigned(Lanes)>;

  Flatten(GeometryTree& out, int kind, const GeometryInPartition& part)
      : out_(out), kind_(kind), part_(part) {}

  void all(const typename Tree::Inner& root, const Advance& advance) {
    size_t nodes = 0, leaves = 0;
    count(root, nodes, leaves);
    if (leaves > TREE_LEAF_NUMBER || nodes > UINT32_MAX / Lanes)
      throw Error("a partition has too many primitives for its tree of " + std::to_string(leaves) +
                  " leaves; cut the data into more partitions");
    out_.nodes.reserve(nodes * TREE_NODE_ROWS * Lanes);
    leaves_.reserve(leaves);
    node(root);
    out_.leaves.resize(leaves * size_t(rowsOf(kind_) + 1) * Lanes);
    parallelFor(
        size_t(0), leaves, [&](size_t number) { fill(number, *leaves_[number]); }, advance);
  }

 private:
  static void count(const typename Tree::Inner& n, size_t& nodes, size_t& leaves) {
    nodes++;
    for (size_t k = 0; k < n.count; k++) {
      if (n.child[k]->leaf)
        leaves++;
      else
        count(static_cast<const typename Tree::Inner&>(*n.child[k]), nodes, leaves);
    }
  }

  uint32_t node(const typename Tree::Inner& n) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const size_t at = out_.nodes.size();
    out_.nodes.resize(at + TREE_NODE_ROWS * Lanes);
    for (size_t k = 0; k < Lanes; k++) {
      std::array<float, 6> sides{kInfinity, kInfinity, kInfinity, -kInfinity, -kInfinity, -kInfinity};
      uint32_t word = 0;
      if (k < n.count) {
        const RTCBounds& b = n.bounds[k];
        sides = {b.lower_x, b.lower_y, b.lower_z, b.upper_x, b.upper_y, b.upper_z};
        word = n.child[k]->leaf ? leaf(static_cast<const typename Tree::Leaf&>(*n.child[k]))
                                : node(static_cast<const typename Tree::Inner&>(*n.child[k]));
      }
      for (size_t side = 0; side < 6; side++)
        out_.nodes[at + side * Lanes + k] = std::bit_cast<uint32_t>(sides[side]);
      out_.nodes[at + 6 * Lanes + k] = word;
    }
    return uint32_t(at / (TREE_NODE_ROWS * Lanes));
  }

  uint32_t leaf(const typename Tree::Leaf& n) {
    const auto number = uint32_t(leaves_.size());
    leaves_.push_back(&n);
    return TREE_LEAF | (n.count - 1) << TREE_COUNT_SHIFT | number;
  }

  void fill(size_t number, const typename Tree::Leaf& n) {
    const size_t rows = size_t(rowsOf(kind_));
    float* leaf = out_.leaves.data() + number * (rows + 1) * Lanes;
    for (size_t i = 0; i < Lanes; i++) {
      const unsigned primitive = n.primitives[std::min<size_t>(i, n.count - 1)][1];
      const auto numbers = rowsOf(kind_, part_, primitive);
      for (size_t row = 0; row < rows; row++) leaf[row * Lanes + i] = numbers[row];
      leaf[rows * Lanes + i] = std::bit_cast<float>(primitive);
    }
  }

  GeometryTree& out_;
  const int kind_;
  const GeometryInPartition& part_;
  std::vector<const typename Tree::Leaf*> leaves_;
};

template <size_t Lanes>
GeometryTree built(int kind, const GeometryInPartition& part, const Advance& advance) {
  const Advance building = partOf(advance, 0, 2), filling = partOf(advance, 1, 2);
  std::vector<RTCBuildPrimitive> primitives;
  embree::addPrimitives(primitives, 0, kind, part);
  const embree::Device device;
  // Leaves are as full as possible, because a step takes as long for one primitive as for all lanes.
  const typename Flatten<Lanes>::Tree tree(device, std::move(primitives), TREE_DEEPEST, Lanes, building);
  GeometryTree out;
  Flatten<Lanes>(out, kind, part).all(tree.root(), filling);
  return out;
}

}  // namespace

GeometryTree buildGeometryTree(int kind, const GeometryInPartition& part, int lanes, const Advance& advance) {
  switch (lanes) {
    case 4:
      return built<4>(kind, part, advance);
    case 8:
      return built<8>(kind, part, advance);
    case 16:
      return built<16>(kind, part, advance);
    default:
      throw Error("geometry tree: gangs of " + std::to_string(lanes) + ", expected 4, 8 or 16");
  }
}

}  // namespace gxy
