// SPDX-License-Identifier: Apache-2.0
// A backend's picture against the reference renderer's: every pixel is equal within the tolerance, a flip, or wrong.
#pragma once
#include <string>
#include <vector>

#include "tests/agreement/draw.h"

namespace gxy::agreement {

struct Comparison {
  double largest = 0;        ///< difference of any channel of a pixel that is no flip
  int pixels = 0, seen = 0;  ///< all; those with something in front of the background
  int flips = 0;
  std::vector<glm::ivec2> wrong;
  int wrongDepths = 0;
  bool finite = true;  ///< no NaN and no infinity in the backend's picture
  std::string report;  ///< for people: the above and the worst pixels
};

struct CompareOptions {
  double tolerance = 1.0 / 512;
  double perturbation = 8;  ///< float ulps by which the rays of the reference move to tell flips
  int seeds = 24;           ///< moves of each pixel; 10 and 1000 times as many where it seems wrong
  uint32_t frameNumber = 0;
  bool vulkan = true;  ///< whether the second backend draws it, too
};

/// Embree's picture, which the Vulkan backend, where it is built, is expected to draw to the bit
/// (same_bits.h).
Picture drawnByBoth(const TestScene& scene, uint32_t frameNumber = 0);

/// Renders with both, ambient occlusion with the backend's own directions; and where the backend is the first one, with
/// the second, too, if options ask for it (drawnByBoth).
///
/// A pixel that differs by more than the tolerance is a flip where the reference itself changes under perturbation (of
/// its rays, of volumes that are rendered together against each other, and of isovalues by as many ulps of the largest
/// sample, which the value along a ray may be off by), and the backend's value lies among the perturbed reference's,
/// extended by the tolerance, and by their spread for each further ray of the pixel (depths: by a hundredth of it). When a
/// pixel is wrong, or flips are more than 0.1 %, the pictures and their difference (times 8) are written as
/// NAME_{backend,reference,difference}.png into the test's temporary folder.
Comparison compare(const Backend& backend, const TestScene& scene, const CompareOptions& options = {});

/// The pixels by which the reference differs from itself by more than the tolerance under one of the perturbations: that which
/// changes most. As long as the pictures of all of them take.
int pixelsThatMove(const TestScene& scene, const CompareOptions& options);

/// Expects no wrong pixel, at most 0.1 % flips (or `flips` of them), and something to see in at least `seen` pixels.
void expectAgreement(const Backend& backend, const TestScene& scene, const CompareOptions& options = {},
                     int flips = -1, int seen = 100);

/// The backend's directions of ambient occlusion, for the reference.
reference::AoDirections backendDirections(const TestScene& scene, uint32_t frameNumber);

}  // namespace gxy::agreement
