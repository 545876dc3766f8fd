// SPDX-License-Identifier: Apache-2.0
// A program outside Galaxy's tree: sees the installed headers, links the installed libraries.
#include <cstdio>

#include "gxy/data/partitioning.h"
#include "gxy/kernels/twin.h"

int main() {
  const auto blocks = gxy::decompose(8, {100, 100, 100});
  const double opacity = gxy::twin::oneMinusExp(0.25);
  std::printf("%d x %d x %d blocks; opacity at optical depth 0.25: %g\n", blocks[0], blocks[1], blocks[2],
              opacity);
  return blocks == std::array{2, 2, 2} && opacity > 0.2211 && opacity < 0.2213 ? 0 : 1;
}
