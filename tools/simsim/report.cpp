// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/report.h"

#include <algorithm>

#include "insitu/api/galaxy_insitu.h"

namespace gxy::simsim {

Outcome outcomeOf(std::span<const int> results) {
  const auto some = [results](int result) { return std::ranges::count(results, result) > 0; };
  if (some(GXY_LOST)) return Outcome::NoConnection;
  if (some(GXY_OFF)) return Outcome::Off;
  if (!some(GXY_NOT_TAKEN)) return Outcome::Taken;
  return some(GXY_TAKEN) ? Outcome::LeftOut : Outcome::NotNeeded;
}

std::string lineAbout(int64_t step, Outcome outcome, const std::string& message) {
  const std::string line = "step " + std::to_string(step) + ": ";
  switch (outcome) {
    case Outcome::Taken:
      return line + "taken";
    case Outcome::NotNeeded:
      return line + "nobody needs it";
    case Outcome::LeftOut:
      return line + "left out: it was asked for when some ranks had passed it";
    case Outcome::Off:
      return line + "publishing is off";
    case Outcome::NoConnection:
      break;
  }
  return line + (message.empty() ? "no connection so far" : "no connection: " + message);
}

}  // namespace gxy::simsim
