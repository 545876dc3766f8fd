// SPDX-License-Identifier: Apache-2.0
// What users are told about a step.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace gxy::simsim {

/// What has become of a step, by the results of gxy_publish() on all ranks of this process.
enum class Outcome {
  Taken,         ///< all have taken it
  NotNeeded,     ///< none has taken it
  LeftOut,       ///< some have taken it, and others have not, so it is given up
  Off,           ///< publishing is off
  NoConnection,  ///< on one rank at least
};

/// `results` are one or more of gxy_result, without GXY_WRONG.
Outcome outcomeOf(std::span<const int> results);

/// Returns a line such as "step 3: taken". `message` is the interface's, about a missing connection; it is
/// empty as long as connecting has not failed.
std::string lineAbout(int64_t step, Outcome outcome, const std::string& message);

}  // namespace gxy::simsim
