// SPDX-License-Identifier: Apache-2.0
// Charts with logarithmic axes, written by VTK as SVG. They need no display and no OpenGL.
#pragma once
#include <string>
#include <vector>

namespace gxy::bench {

struct Curve {
  std::string name;
  std::vector<double> x, y;  ///< positive; drawn in this order
};

struct Chart {
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
  double line = 0;            ///< a horizontal line there, unless 0
  std::string lineName = {};  ///< name of the line in the legend
  int width = 620, height = 460;
};

/// Writes a chart to a file. Points that are not positive and finite are left out. Throws Error when the file
/// cannot be written.
void writeChart(const std::string& path, const Chart& chart);

}  // namespace gxy::bench
