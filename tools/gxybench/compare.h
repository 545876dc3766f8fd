// SPDX-License-Identifier: Apache-2.0
// Compares two tables of gxybench: which curves moved.
#pragma once
#include <string>
#include <vector>

#include "tools/gxybench/table.h"

namespace gxy::bench {

/// The columns that are the time and the error of a curve.
struct CurveAxes {
  bool wall = false;  ///< time is wall time, otherwise processor time
  double Row::*error = &Row::rmsError;
};

/// The changes in one curve: a scene, method, backend and number of ranks.
struct Change {
  std::string scene, curve;
  /// New time over old time at equal error: the geometric mean, smallest and largest over the errors that
  /// both curves reach, interpolated between settings in the logarithms of both. 0 if the two curves have no
  /// error in common.
  double ratio = 0, least = 0, most = 0;
  double noise = 0;  ///< relative noise of times, from the spreads of the repeats; at least 2 %
  /// The ratios are of times at equal settings, because the errors do not overlap or there is one setting.
  bool atSettings = false;
  double errorRatio = 1;  ///< new error over old error at equal settings, geometric mean
  std::string remark;     ///< what is worse besides time, or missing
  bool slower() const { return ratio > 1 + noise; }
  bool faster() const { return ratio > 0 && ratio < 1 / (1 + noise); }
  bool regressed() const { return slower() || !remark.empty(); }
};

/// Returns the changes of every curve of either table, by scene, in the order of the new one.
std::vector<Change> changes(const std::vector<Row>& older, const std::vector<Row>& newer,
                            const CurveAxes& axes);

/// A text for users with one line per curve.
std::string report(const std::vector<Change>& all);

}  // namespace gxy::bench
