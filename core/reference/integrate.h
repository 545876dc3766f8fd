// SPDX-License-Identifier: Apache-2.0
// Emission and absorption along a ray, integrated by adaptive quadrature.
#pragma once
#include <span>
#include <variant>
#include <vector>

#include "core/reference/cubic.h"
#include "core/reference/field.h"
#include "core/reference/mesh_field.h"
#include "core/reference/ray.h"
#include "core/reference/transfer.h"

namespace gxy::reference {

/// A volume as a ray sees it, on a grid or on a mesh. What it points to must outlive the use.
struct VolumeTerm {
  std::variant<const Field*, const MeshField*> field;
  const Transfer* transfer;
  Interval clip{-kInfinity, kInfinity};  ///< interval of t in which the volume is visible
};

/// The contribution of a stretch of a ray to the picture, seen from its start: premultiplied colour, and the
/// fraction of light that passes.
struct RayIntegral {
  glm::dvec3 colour{0};
  double transmittance = 1;
};

/// The volumes along one ray, prepared for integration over any stretches of it. Extinctions and sources of
/// overlapping volumes add up.
class VolumeRay {
 public:
  VolumeRay(std::span<const VolumeTerm> terms, const Ray& ray, Interval range = {});

  /// Returns colour = integral of T sigma c dt and T(end), within `tolerance` for colours in [0, 1]. The
  /// stretch is cut at cell faces and where a field crosses a control point of its maps. Each smooth piece is
  /// integrated by five-point Gauss collocation (order 10 in colour, with the optical depth at every node)
  /// and halved until the result stands still. A piece on which an opacity is 1 ends the ray.
  RayIntegral integrate(Interval stretch, double tolerance = 1e-6) const;

 private:
  struct Span {
    double t0, t1;  ///< where the ray enters and leaves the cell; the cubic runs between
    Interval seen;  ///< the visible part of it
    Cubic field;
    const Transfer* transfer;
  };
  struct Piece {
    double optical;  ///< optical depth
    glm::dvec3 colour;
  };
  struct Running {
    RayIntegral total;
    double tolerance;
  };
  /// A span, with the linear maps that hold on a smooth piece.
  struct ActiveSpan {
    const Span* span;
    LinearTransfer maps;
    double value(double t) const { return span->field.value((t - span->t0) / (span->t1 - span->t0)); }
  };
  using Active = std::vector<ActiveSpan>;

  /// Adds a cell that the ray is in from t0 to t1, unless it is transparent. The cubic runs between.
  void addCell(size_t term, const VolumeTerm& how, Interval visible, Interval cell, const Cubic& cubic);
  void addCells(size_t term, const VolumeTerm& how, const Field& field, const Ray& ray, Interval visible);
  void addCells(size_t term, const VolumeTerm& how, const MeshField& field, const Ray& ray, Interval visible);

  static Piece gauss(const Active& active, double a, double b);
  static void adapt(const Active& active, double a, double b, const Piece& coarse, int depth,
                    Running& running);
  static void integratePiece(const Active& active, double a, double b, Running& running);

  /// Per term, in the order of entry; transparent cells are left out. Where cells of a mesh overlap, the first one that the ray is
  /// in counts up to its end.
  std::vector<std::vector<Span>> spans_;
  std::vector<double> breaks_;  ///< t, ascending, at which smoothness may end
};

/// The integral over one stretch of a ray through one or several volumes.
RayIntegral integrateRay(std::span<const VolumeTerm> terms, const Ray& ray, Interval stretch = {},
                         double tolerance = 1e-6);

}  // namespace gxy::reference
