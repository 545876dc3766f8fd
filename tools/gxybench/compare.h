// SPDX-License-Identifier: Apache-2.0
// Two tables of gxybench: which curves moved.
#pragma once
#include <string>
#include <vector>

#include "tools/gxybench/table.h"

namespace gxy::bench {

/// Which columns are the time and the error of a curve.
struct CurveAxes {
  bool wall = false;  ///< else processor time
  double Row::*error = &Row::rmsError;
};

/// What became of one curve: a scene, method, backend and number of ranks.
struct Change {
  std::string scene, curve;
  /// New time over old time at equal error: the geometric mean, smallest and largest over the errors that
  /// both curves reach, interpolated between settings in the logarithms of both. 0 where they have nothing in
  /// common.
  double ratio = 0, least = 0, most = 0;
  double noise = 0;  ///< relative; from the spreads of the repeats, at least 2 %
  /// The errors do not overlap, or there is one setting: times at equal settings instead.
  bool atSettings = false;
  double errorRatio = 1;  ///< new error over old at equal settings, geometric mean
  std::string remark;     ///< what is worse besides time, or missing
  bool slower() const { return ratio > 1 + noise; }
  bool faster() const { return ratio > 0 && ratio < 1 / (1 + noise); }
  bool regressed() const { return slower() || !remark.empty(); }
};

/// Every curve of either table, by scene, in the order of the new one.
std::vector<Change> changes(const std::vector<Row>& older, const std::vector<Row>& newer,
                            const CurveAxes& axes);

/// For people: one line a curve.
std::string report(const std::vector<Change>& all);

}  // namespace gxy::bench
