// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

namespace gxy {

/// Accepts numbers from `least` to `most`. Unlike CLI::Range it refuses NaN, which is neither below nor above them.
inline CLI::Validator numberFrom(double least, double most) {
  std::ostringstream range;
  range << "FLOAT in [" << least << " - " << most << "]";
  return {[least, most, expected = range.str()](const std::string& text) {
            double value = 0;
            const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
            return good ? std::string() : "expected " + expected + ", found '" + text + "'";
          },
          range.str()};
}

}  // namespace gxy
