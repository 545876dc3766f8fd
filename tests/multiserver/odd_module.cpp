// SPDX-License-Identifier: Apache-2.0
// A module whose verbs return what no reply may hold.
#include "multiserver/server/module.h"

GALAXY_MODULE(registration) {
  using nlohmann::json;
  registration.verb({"list_of_two", "", "", gxy::Order::InTurn, [](gxy::Request&) -> json {
                       return {1, 2};
                     }});
  registration.verb({"text", "", "", gxy::Order::InTurn, [](gxy::Request&) -> json { return "text"; }});
  registration.verb({"object", "", "", gxy::Order::InTurn, [](gxy::Request&) { return json{{"a", 1}}; }});
}
