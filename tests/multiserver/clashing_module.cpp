// SPDX-License-Identifier: Apache-2.0
// A module whose second work is named like one of the server's own.
#include "multiserver/server/module.h"

GALAXY_MODULE(registration) {
  const auto nothing = [](const gxy::Work::Call&) -> nlohmann::json { return nullptr; };
  registration.work("clashing.first", nothing);
  registration.work("datasets.info", nothing);
}
