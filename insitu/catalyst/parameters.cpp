// SPDX-License-Identifier: Apache-2.0
#include "insitu/catalyst/parameters.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

namespace gxy::catalyst {

namespace {

using nlohmann::json;

// A rank and the number of ranks, as launchers tell them to a process.
std::pair<int64_t, int64_t> ofLauncher() {
  // SLURM_NTASKS would also be there for a single process in a batch job.
  constexpr const char* names[][2] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                      {"PMI_RANK", "PMI_SIZE"},
                                      {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};
  for (const auto& [rankName, ranksName] : names) {
    const char *rank = std::getenv(rankName), *ranks = std::getenv(ranksName);
    if (rank && ranks) return {std::atoll(rank), std::atoll(ranks)};
  }
  return {0, 1};
}

json jsonOf(const Node& node) {
  if (node.isText()) return node.text();
  if (!node.isNumbers()) {
    json object = json::object();
    for (const Node& child : node.children()) object[child.name()] = jsonOf(child);
    return object;
  }
  const std::vector<double> numbers = node.numbers(size_t(node.array().count));
  return numbers.size() == 1 ? json(numbers[0]) : json(numbers);
}

[[noreturn]] void expected(const std::string& key, const char* what) {
  throw std::runtime_error("catalyst/galaxy/" + key + ": expected " + what);
}

void read(const json& all, const char* key, std::string& to) {
  if (!all.contains(key)) return;
  if (!all[key].is_string()) expected(key, "a text");
  to = all[key];
}

void read(const json& all, const char* key, double& to) {
  if (!all.contains(key)) return;
  if (!all[key].is_number()) expected(key, "a number");
  to = all[key];
}

int integer(const json& all, const char* key, int64_t otherwise) {
  double value = double(otherwise);
  read(all, key, value);
  if (value < 0 || value > 0x1p30 || value != double(int64_t(value))) expected(key, "an integer from 0 up");
  return int(value);
}

// Numbers of an array, or one of each member.
std::vector<double> numbers(const json& value, const std::string& key, size_t count) {
  std::vector<double> all;
  for (const json& one : value) {
    if (!one.is_number()) break;
    all.push_back(one);
  }
  if (!value.is_structured() || all.size() != count || value.size() != count)
    expected(key, count == 3 ? "3 numbers" : "6 numbers");
  return all;
}

WholeGrid wholeGrid(const json& all, const std::string& path) {
  WholeGrid grid;
  if (all.contains("size")) {
    const auto n = numbers(all["size"], path + "size", 3);
    if (!std::all_of(n.begin(), n.end(), [](double points) {
          return points >= 1 && points <= 0x1p31 && points == std::floor(points);
        }))
      expected(path + "size", "1 to 2^31 points by axis");
    grid.size = {int64_t(n[0]), int64_t(n[1]), int64_t(n[2])};
  }
  if (all.contains("origin")) {
    const auto x = numbers(all["origin"], path + "origin", 3);
    grid.origin = {x[0], x[1], x[2]};
  }
  if (all.contains("spacing")) {
    const auto dx = numbers(all["spacing"], path + "spacing", 3);
    grid.spacing = {dx[0], dx[1], dx[2]};
  }
  return grid;
}

json parsed(const char* path) {
  std::ifstream file(path);
  json all = json::parse(file, nullptr, false);
  if (!all.is_object())
    throw std::runtime_error("GALAXY_CATALYST: " + std::string(path) +
                             ": expected a file with a JSON object");
  const std::set<std::string> known{"association", "box",  "ghosts", "grids",   "ids",    "name", "options",
                                    "origin",      "rank", "ranks",  "seconds", "shared", "size", "spacing"};
  for (const auto& [key, value] : all.items())
    if (!known.count(key))
      throw std::runtime_error("GALAXY_CATALYST: " + std::string(path) + ": \"" + key + "\" is not known");
  return all;
}

}  // namespace

Parameters readParameters(const Node& params) {
  const auto node = params.find("catalyst/galaxy");
  json all = node ? jsonOf(*node) : json::object();
  if (!all.is_object()) throw std::runtime_error("catalyst/galaxy: expected an object");
  if (const char* path = std::getenv("GALAXY_CATALYST"); path && *path) all.update(parsed(path));
  const auto [rank, ranks] = ofLauncher();
  Parameters p;
  p.rank = integer(all, "rank", rank);
  p.ranks = integer(all, "ranks", ranks);
  read(all, "name", p.name);
  read(all, "options", p.options);
  read(all, "ghosts", p.ghosts);
  read(all, "ids", p.ids);
  read(all, "association", p.association);
  if (!p.association.empty() && p.association != "vertex" && p.association != "element")
    expected("association", "\"vertex\" or \"element\"");
  read(all, "seconds", p.seconds);
  p.shared = integer(all, "shared", 1) != 0;
  if (all.contains("box")) p.box = numbers(all["box"], "box", 6);
  p.wholes[""] = wholeGrid(all, "");
  if (!all.contains("grids")) return p;
  if (!all["grids"].is_object()) expected("grids", "an object with a member for each mesh");
  for (const auto& [mesh, grid] : all["grids"].items())
    p.wholes[mesh] = wholeGrid(grid, "grids/" + mesh + "/");
  return p;
}

}  // namespace gxy::catalyst
