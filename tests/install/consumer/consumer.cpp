// SPDX-License-Identifier: Apache-2.0
// A program outside Galaxy's tree: sees the installed headers, links the installed libraries.
#include <cmath>
#include <cstdio>

#include "gxy/kernels/twin.h"

int main() {
  const double depth = 0.25;
  const double opacity = gxy::twin::oneMinusExp(depth);
  std::printf("opacity at optical depth %g: %g\n", depth, opacity);
  return std::abs(opacity - (1 - std::exp(-depth))) < 1e-15 ? 0 : 1;
}
