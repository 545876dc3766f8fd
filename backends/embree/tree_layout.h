// SPDX-License-Identifier: Apache-2.0
// How geometry's trees lie in memory, for C++ and ISPC. `lanes` is the width of a gang.
//
// A node is 7 rows of `lanes` words, one for each child: lower x, y, z and upper x, y, z of its box, and its word. The word is the
// number of a node, or TREE_LEAF, how many primitives a leaf has less one, and its number. A missing child has a box that nothing
// meets; node 0 is the root.
//
// A leaf is rows of `lanes` numbers, one for each primitive, and a row of which these are (uint32). Where there are fewer, the last is
// repeated.
#pragma once

#define TREE_NODE_ROWS 7
#define TREE_LEAF 0x80000000u
#define TREE_COUNT_SHIFT 27
#define TREE_LEAF_NUMBER 0x07ffffffu
#define TREE_DEEPEST 32  // nodes on the way to a leaf

#define TREE_SPHERE_ROWS 4  // centre, radius
#define TREE_TUBE_ROWS 18   // two points, those before and after (x y z radius each); whether there are these
#define TREE_TRIANGLE_ROWS 9  // three corners
