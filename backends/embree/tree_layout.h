// SPDX-License-Identifier: Apache-2.0
// The memory layout of geometry trees, for C++ and ISPC. `lanes` is the width of a gang.
//
// A node is 7 rows of `lanes` words, with one column for each child: lower x, y, z and upper x, y, z of its
// box, and its word. The word of an inner child is the number of its node. The word of a leaf is TREE_LEAF,
// the number of its primitives less one, and its number. A missing child has a box that nothing meets. Node 0
// is the root.
//
// A leaf is rows of `lanes` numbers, with one column for each primitive, and a last row with the primitives'
// indices (uint32). If there are fewer primitives than lanes, the last one is repeated.
#pragma once

#define TREE_NODE_ROWS 7
#define TREE_LEAF 0x80000000u
#define TREE_COUNT_SHIFT 27
#define TREE_LEAF_NUMBER 0x07ffffffu
#define TREE_DEEPEST 32  // most nodes on the way to a leaf

#define TREE_SPHERE_ROWS 4  // centre, radius
// Two points, the points before and after (x y z radius each), and whether those two exist.
#define TREE_TUBE_ROWS 18
#define TREE_TRIANGLE_ROWS 9  // three corners
#define TREE_CELL_ROWS 16     // four corners and their levels
#define TREE_SHELL_ROWS 10    // three corners, and the face (GeometryInPartition::shell)
// The same of hexahedra: eight corners and their levels, and the orders of the sides; four corners in order, the face, and whether it is a
// triangle.
#define TREE_HEX_CELL_ROWS 33
#define TREE_HEX_SHELL_ROWS 14
#define TREE_MOST_ROWS 33
