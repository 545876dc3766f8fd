// SPDX-License-Identifier: Apache-2.0
// Hexahedra, wedges and pyramids along a ray.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/data/mesh.h"
#include "core/reference/cell_face.h"
#include "core/reference/cell_map.h"
#include "core/reference/cubic.h"
#include "core/reference/ray.h"

namespace gxy::reference {

/// A hexahedron, wedge or pyramid with its corners in the order of VTK. It is never split: quadrilaterals are bilinear patches, and
/// places and values inside are those of VTK's shape functions. `numbers` are those of its points in the mesh.
struct BentCell {
  CellType type = CellType::Hexahedron;
  std::array<glm::dvec3, 8> corner{};
  std::array<uint32_t, 8> numbers{};

  std::span<const glm::dvec3> corners() const { return std::span(corner).first(shapeOf(type).points); }
};

/// A part of a ray in a cell, from one face to another, in.t <= out.t.
struct CellPassage {
  FaceMeeting in, out;
};

/// A part of a passage on which something is a cubic of (t - t0) / (t1 - t0).
struct CellStretch {
  double t0, t1;
  Cubic value;
};

/// Where something changes its sign along a ray.
struct CellRoot {
  double t;
  glm::dvec3 place;  ///< in the reference coordinates of shapeAt()
};

/// A cell as a ray meets it. The cell must outlive it.
class CellOnRay {
 public:
  CellOnRay(const BentCell& cell, const Ray& ray);

  /// Returns the parts of the ray's line in the cell, by ascending out.t. Meetings with the faces that turn one way around the ray are
  /// joined with those that turn the other way, each in the order of t. So the orientation of the cell as a whole has no effect, each
  /// meeting is the end of exactly one part, and places that a tangled cell covers once up and once down are outside. Where a ray meets
  /// several faces at once, parts may have no length.
  std::vector<CellPassage> passages() const;

  /// The passage in stretches. At all their ends the cubics have the values of what the shape functions make of `values`, in between they
  /// differ by no more than `tolerance` (or what rounding allows, in cells that are nearly flat). At the ends of the passage values are
  /// those of the faces. Where a tangled cell has no inverse, it is linear.
  std::vector<CellStretch> stretches(const CellPassage& passage, const OfCorners& values,
                                     double tolerance) const;

  /// Returns where the sign of what has these values at the corners changes in the passage, ascending: > 0 against <= 0. These are as many,
  /// even or odd, as the signs on the faces say, so there are neither cracks nor double roots between cells. Pairs of roots are found
  /// unless the value between them is within about 1e-8 of its range in the cell.
  std::vector<CellRoot> roots(const CellPassage& passage, const OfCorners& values) const;

  /// The place in reference coordinates at a t in a passage.
  glm::dvec3 placeAt(const CellPassage& passage, double t) const;

 private:
  struct Sample {
    double t;
    glm::dvec3 place;
    double value;
    double noise = 0;  ///< of the place
    bool found = true;
  };
  struct Split;
  glm::dvec3 placeOf(const FaceMeeting& meeting) const;
  Sample end(const FaceMeeting& meeting, const OfCorners& values) const;
  Sample between(const Sample& a, const Sample& b, double t, const OfCorners& values) const;
  /// Samples at 0, 1/3, 2/3 and 1 of a stretch.
  using FourSamples = std::array<Sample, 4>;
  /// Adds the stretches of one that may be too long, with their cubics.
  void split(const Split& how, const FourSamples& at, int depth, std::vector<FourSamples>& stretches,
             std::vector<Cubic>& cubics) const;
  std::vector<Cubic> cubicsOf(const Split& how, const Sample& in, const Sample& out,
                              std::vector<FourSamples>& stretches) const;
  CellRoot root(Sample a, Sample b, const OfCorners& values) const;

  const BentCell* cell_;
  std::array<glm::dvec3, 8> seen_{};  ///< the corners in the ray's frame
};

}  // namespace gxy::reference
