// SPDX-License-Identifier: Apache-2.0
#include "core/reference/isosurface.h"

#include "core/reference/cells.h"

namespace gxy::reference {

std::optional<double> firstRoot(const Field& field, const Ray& ray, double isovalue, Interval range,
                                double after) {
  bool onPlateau = false;  // the field equals the isovalue all along the previous cell, up to its end
  for (CellWalk walk(field.grid(), ray); walk.inside(); walk.advance()) {
    if (walk.entry() > range.hi) return std::nullopt;
    auto corners = field.corners(walk.cell());
    if (!corners) {
      onPlateau = false;
      continue;
    }
    // Differences to the isovalue are exact near it, and mixing them makes rounding errors in proportion to
    // them, not to the samples. Around samples of 6e8 doubles are 1e-7 apart.
    for (double& c : *corners) c -= isovalue;
    const double t0 = walk.entry(), t1 = walk.exit();
    const Cubic f = alongRay(*corners, walk.local(t0), walk.local(t1));
    const bool entered = f.b[0] == 0 && !onPlateau;
    onPlateau = f.min() == 0 && f.max() == 0;
    auto accepted = [&](double t) { return range.contains(t) && t > after; };
    if (entered && accepted(t0)) return t0;
    for (double s : roots(f, 0)) {
      const double t = t0 + s * (t1 - t0);
      if (accepted(t)) return t;
    }
    if (walk.last() && f.b[3] == 0 && !onPlateau && accepted(t1)) return t1;
  }
  return std::nullopt;
}

Index3 cellMet(const Field& field, const Ray& ray, double t) {
  Index3 last{};
  for (CellWalk walk(field.grid(), ray); walk.inside(); walk.advance()) {
    last = walk.cell();
    if (walk.exit() >= t && field.corners(last)) break;
  }
  return last;
}

}  // namespace gxy::reference
