// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/options.h"

#include <charconv>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/comm/error.h"
#include "insitu/client/here.h"
#include "insitu/plan/records.h"

namespace gxy::insitu {

using nlohmann::json;

namespace {

json parsed(const std::string& text, const std::string& where) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) throw Error(where + ": expected a JSON object");
  static const std::set<std::string> known{"to",       "token-file", "tenant",    "scope",   "partition",
                                           "policy",   "time-out",   "every",     "between", "reconnect",
                                           "triggers", "here",       "steerable", "checksum"};
  for (const auto& [key, value] : object.items())
    if (known.count(key) == 0) {
      std::string all;
      for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
      throw Error(where + ": there is no option \"" + key + "\", expected one of " + all);
    }
  return object;
}

std::string textOf(const std::string& path, const std::string& what) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw Error(what + ": " + path + " cannot be read, expected a JSON file");
  return text.str();
}

std::string word(const json& options, const char* key, const std::string& otherwise) {
  const auto found = options.find(key);
  if (found == options.end()) return otherwise;
  if (!found->is_string()) throw Error(std::string("option \"") + key + "\": expected a text");
  return found->get<std::string>();
}

void readHere(Options& options) {
  const Here server = here();
  if (server.port == 0)
    throw Error(server.problem.empty() ? "option \"to\": \"here\", but no server runs in this program, "
                                         "expected gxy_open_mpi() of galaxy_insitu_mpi.h"
                                       : server.problem);
  options.on = true;
  options.host = server.host;
  options.port = server.port;
  options.token = server.token;
  options.asksForToken = !server.token.empty();
}

void readWhere(const std::string& to, Options& options) {
  if (to == "off") return;
  if (to == "here") return readHere(options);
  const size_t colon = to.rfind(':');
  int port = 0;
  if (colon != std::string::npos) {
    const char* end = to.data() + to.size();
    const auto [rest, failed] = std::from_chars(to.data() + colon + 1, end, port);
    if (failed != std::errc() || rest != end) port = 0;
  }
  if (colon == 0 || port < 1 || port > 65535)
    throw Error("option \"to\": found \"" + to + "\", expected \"off\", \"here\" or HOST:PORT");
  options.on = true;
  options.host = to.substr(0, colon);
  if (options.host.size() > 2 && options.host.front() == '[')  // [::1]:5001
    options.host = options.host.substr(1, options.host.size() - 2);
  options.port = uint16_t(port);
}

// Those of the program, and of the environment, which go before them.
json allOptions(const char* text) {
  json object = text ? parsed(text, "options of gxy_open") : json::object();
  if (const char* file = std::getenv("GALAXY_INSITU_OPTIONS"); file && *file)
    object.update(
        parsed(textOf(file, "GALAXY_INSITU_OPTIONS"), std::string("GALAXY_INSITU_OPTIONS, ") + file));
  return object;
}

std::string where(const json& options) {
  const char* given = std::getenv("GALAXY_INSITU");
  if (given && *given) return given;
  return word(options, "to", here().port > 0 ? "here" : "off");
}

// Checks the list of parameters that may be steered.
json steerable(const json& list) {
  const std::string expected =
      "option \"steerable\": expected a list of {\"name\", \"least\", \"largest\"}, at most 64";
  if (!list.is_array() || list.size() > kMostSteerable) throw Error(expected);
  for (const json& one : list) {
    if (!one.is_object() || one.size() != 3 || !one.value("name", json()).is_string() ||
        !one.value("least", json()).is_number() || !one.value("largest", json()).is_number() ||
        !(one["least"].get<double>() <= one["largest"].get<double>()))
      throw Error(expected);
    checkName(one["name"].get<std::string>(), "parameter");
  }
  return list;
}

void readPolicy(const json& options, Options& into) {
  const std::string policy = word(options, "policy", "skip");
  const auto patience = options.find("time-out");
  if (policy != "skip" && policy != "wait")
    throw Error("option \"policy\": found \"" + policy + "\", expected \"skip\" or \"wait\"");
  if (policy == "skip") return;
  if (patience == options.end())
    throw Error("option \"time-out\": expected with policy \"wait\": seconds, or null for ever");
  if (!patience->is_null() && (!patience->is_number() || !(patience->get<double>() >= 0)))
    throw Error("option \"time-out\": expected seconds from 0 up, or null for ever");
  into.patience = std::chrono::duration<double>(patience->is_null() ? std::numeric_limits<double>::infinity()
                                                                    : patience->get<double>());
}

}  // namespace

std::string givenOptions(const char* text) { return allOptions(text).dump(); }

bool saysHere(const char* text) { return where(allOptions(text)) == "here"; }

Options readOptions(const char* text) {
  const json object = allOptions(text);
  Options options;
  readWhere(where(object), options);
  options.tokenFile = word(object, "token-file", "");
  options.tenant = word(object, "tenant", options.tenant);
  options.scope = word(object, "scope", options.scope);
  if (options.scope != "private" && options.scope != "shared")
    throw Error("option \"scope\": found \"" + options.scope + "\", expected \"private\" or \"shared\"");
  const char* usual = where(object) == "here" ? "simulation" : "even";
  options.partition = object.value("partition", json(usual)).dump();
  options.steerable = steerable(object.value("steerable", json::array())).dump();
  const json triggers = object.value("triggers", json::array());
  if (!triggers.is_array() && !triggers.is_string())
    throw Error("option \"triggers\": expected a list, or the name of a file that has it");
  options.triggers = triggers.dump();
  readPolicy(object, options);
  const json every = object.value("every", json(1)), between = object.value("between", json());
  if (!every.is_number_integer() || every.get<int64_t>() < 1)
    throw Error("option \"every\": expected an integer from 1 up");
  options.every = every.get<int64_t>();
  if (!between.is_null()) {
    if (!between.is_array() || between.size() != 2 || !between[0].is_number() || !between[1].is_number())
      throw Error("option \"between\": expected two times, [FIRST, LAST]");
    options.firstTime = between[0].get<double>();
    options.lastTime = between[1].get<double>();
  }
  const json checksum = object.value("checksum", json());
  if (!checksum.is_null() && !checksum.is_boolean())
    throw Error("option \"checksum\": expected true, false, or null for all but loopback addresses");
  if (checksum.is_boolean()) options.checksum = checksum.get<bool>();
  const json reconnect = object.value("reconnect", json(5));
  if (!reconnect.is_number() || !(reconnect.get<double>() >= 0) || reconnect.get<double>() > 1e6)
    throw Error("option \"reconnect\": expected seconds, 0 to 10^6");
  options.reconnect = std::chrono::duration<double>(reconnect.get<double>());
  return options;
}

void readTriggers(Options& options) {
  const json given = json::parse(options.triggers);
  if (given.is_array()) return;
  const auto path = given.get<std::string>();
  const json triggers = json::parse(textOf(path, "option \"triggers\""), nullptr, false);
  if (!triggers.is_array())
    throw Error("option \"triggers\": " + path + " has no JSON list, expected one of triggers");
  options.triggers = triggers.dump();
}

}  // namespace gxy::insitu
