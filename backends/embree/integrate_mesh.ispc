// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through an unstructured volume. A tree over the faces of its shell finds where walks begin.
#define MEETS_SHELLS
#include "backends/embree/geometry.isph"
#include "core/kernels/export.h"

static inline void integrateRays(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                                 const uniform int shell, uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  OPERATOR mesh = s.operator_[op];
  const uniform GeometryTreeView* uniform tree = (const uniform GeometryTreeView* uniform)mesh.shellHierarchy;
  int samples = 0, cells = 0, walks = 0;
  uniform GangRays g;
  for (uniform int first = 0; first < n; first += programCount) {
    // Rays meet trees in all lanes, so lanes without a ray have the last one once more, and do nothing with it.
    int i = min(first + programIndex, n - 1);
    bool there = first + programIndex < n;
    takeRay(g, r, i);
    vec3 o = originOf(r, i), d = directionOf(r, i);
    MarchRange m = marchRange(s, r, i);
    Radiance L = radianceOf(r, i);
    FrameRay f = frameRay(o, d);
    takeFrame(g, f.frame);
    MeshMarch w = startMesh(mesh.clips, o, d, m, L.A);
    ShellPlace last = beforeShell();
    float most = min(min(m.tOut, w.end), NO_HIT);
    bool goes = there && w.goes && meetsGeometry(o);
    uniform int64 lone = packmask(RAY_KIND(r.info[i]) == RAY_OCCLUSION);
    for (uniform int64 lanes = packmask(goes); lanes != 0; lanes = packmask(goes)) {
      LANE(g, tAfter) = last.t;
      LANE(g, number) = last.number;
      LANE(g, ended) = last.ended;
      // Boxes are met within rounding.
      LANE(g, tNear) = last.t - 1e-5f * (abs(last.t) + LANE(g, perLength));
      LANE(g, tFar) = most;
      LANE(g, tClip) = most;
      LANE(g, primitive) = NO_PRIMITIVE;
      meetBundles(g, lanes, lone, shell, *tree, false, false);
      goes = goes && LANE(g, primitive) != NO_PRIMITIVE;
      if (goes) {
        last.t = LANE(g, tFar);
        last.number = LANE(g, primitive);
        if (shell == KIND_SHELL)
          last.ended = walkMesh(mesh, f, m, shellFace(mesh, last.number), w, L, samples, cells);
        else
          last.ended = walkHexahedra(mesh, f, m, shellFace(mesh, last.number), w, L, samples, cells);
        walks++;
        goes = w.goes;
      }
    }
    if (there) setRadiance(s, r, i, L);
  }
  counts[0] += reduce_add((int64)samples);
  counts[1] += reduce_add((int64)cells);
  counts[2] += reduce_add((int64)walks);
}

EXPORT void integrateRaysOfMesh(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                                uniform int64 counts[]) {
  integrateRays(scene, rays, n, op, KIND_SHELL, counts);
}

EXPORT void integrateRaysOfHexahedra(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                                     uniform int64 counts[]) {
  integrateRays(scene, rays, n, op, KIND_HEX_SHELL, counts);
}
