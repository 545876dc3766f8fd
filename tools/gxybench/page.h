// SPDX-License-Identifier: Apache-2.0
// The results of a run for users: one or two charts of each scene, and a page that shows them all.
#pragma once
#include <string>
#include <vector>

#include "tools/gxybench/table.h"

namespace gxy::bench {

/// A scene's name and description.
struct Heading {
  std::string name, about;
};

/// Writes FOLDER/NAME-max.svg and FOLDER/NAME-rms.svg from the scene's rows: processor time across, error up,
/// a curve for each method, backend and number of ranks.
void writeCharts(const std::string& folder, const std::string& scene, const std::vector<Row>& rows);

/// Writes FOLDER/index.html with the charts and the rows of all scenes. `command` is the command line of the
/// run.
void writePage(const std::string& folder, const std::vector<Heading>& scenes, const std::vector<Row>& rows,
               const std::string& command);

}  // namespace gxy::bench
