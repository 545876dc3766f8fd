// SPDX-License-Identifier: Apache-2.0
// What a server's filters make has the same bytes as a file, on however many ranks.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>

#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

struct FileOfFilter {
  std::string filter, name, extension;  ///< no extension: the filter tells numbers only
  json inputs, properties;
};

/// Each filter, with inputs that those before have made.
std::vector<FileOfFilter> filesOfFilters() {
  const json shell{{"dataset", "f"}, {"isovalues", {0.4, 0.7}}, {"hits", 2}, {"next", {{"spawn", 3}}}};
  const json steps{{"dataset", "e"}, {"every", 0.3}};
  return {
      {"Derive", "flow", ".vti", {{"f", "ball"}}, {{"expression", "[x * z - y, x + 0.1 * f, cos(3 * f)]"}}},
      {"Derive", "turns", ".vti", {{"u", "flow"}}, {{"expression", "if(z > 0.6, nodata, mag(curl(u)))"}}},
      {"Seeds",
       "seeds",
       ".vtp",
       {{"domain", "ball"}},
       {{"shape", "sphere"}, {"count", 200}, {"radius", 0.9}}},
      {"DensitySampler",
       "density",
       ".vtp",
       {{"field", "turns"}, {"values", "flow"}},
       {{"count", 400}, {"seed", 3}, {"gradient", true}}},
      {"IsosurfaceSampler",
       "surface",
       ".vtp",
       {{"field", "ball"}, {"values", {"turns", "flow"}}},
       {{"isovalue", 0.6}, {"count", 400}, {"gradient", true}}},
      {"RaySampler",
       "rays",
       ".vtp",
       {{"f", "ball"}, {"e", "turns"}, {"u", "flow"}},
       {{"operators", {shell, steps}}, {"lines", 150}, {"values", {"u", "e"}}, {"gradient", true}}},
      {"StreamTracer",
       "lines",
       ".vtu",
       {{"vectors", "flow"}, {"seeds", "seeds"}, {"field", "ball"}, {"fields", "turns"}},
       {{"direction", "both"}, {"length", 3}, {"color by", "field"}, {"fields", {"time", "vorticity"}}}},
      {"StreamTracer",
       "samples",
       ".vtp",
       {{"vectors", "flow"}, {"seeds", "seeds"}},
       {{"time", 2}, {"points", {{"ds", 0.05}}}}},
      {"Interpolate", "values", ".vtp", {{"points", "seeds"}, {"fields", {"turns", "flow"}}}, json::object()},
      {"Interpolate", "on lines", ".vtu", {{"points", "lines"}, {"fields", "flow"}}, {{"component", 2}}},
      {"Resample", "finer", ".vti", {{"field", "flow"}}, {{"dimensions", {21, 34, 13}}}},
      {"Resample", "like", ".vti", {{"field", "turns"}, {"like", "ball"}}, json::object()},
      {"Statistics",
       "",
       "",
       {{"field", "turns"}, {"f", "ball"}},
       {{"where", "f > 0.4"}, {"histogram", 16}, {"quantiles", {0.1, 0.5}}}},
      {"Statistics", "", "", {{"field", "lines"}}, {{"array", "vorticity"}, {"quantiles", {0.9}}}},
      {"Number", "", "", {{"u", "flow"}, {"f", "ball"}}, {{"expression", "max(u.0) - min(f)"}}},
  };
}

std::string bytesOfFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The bytes of what each filter makes, or what it tells, on a server of so many ranks.
std::vector<std::string> bytesMade(int ranks, std::set<std::string>& known) {
  ServerSetup setup;
  setup.ranks = ranks;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  for (const char* module : {"data", "analysis"}) client->expect(std::string("load ") + module);
  client->expect(importBall("ball"));
  const json filters = client->expect("filters");
  for (const json& filter : filters.at("filters")) known.insert(filter.at("name"));
  std::vector<std::string> all;
  for (const FileOfFilter& file : filesOfFilters()) {
    json entry = file.properties;
    entry.update({{"filter", file.filter}, {"inputs", file.inputs}});
    if (!file.name.empty()) entry["name"] = file.name;
    const json told = client->expect("make " + entry.dump()).at("results").at(0);
    all.push_back(told.dump());
    if (file.extension.empty()) continue;
    const std::string name = "made" + file.extension;
    client->expect("export \"" + file.name + "\" " + name);
    all.push_back(bytesOfFile((server.folder().path() / name).string()));
  }
  return all;
}

TEST(FilterFiles, HaveTheSameBytesOnServersOfOneThreeAndEightRanks) {
  std::set<std::string> known, tested;
  std::vector<std::string> what;
  for (const FileOfFilter& file : filesOfFilters()) {
    tested.insert(file.filter);
    what.push_back("what " + file.filter + " " + file.name + " tells");
    if (!file.extension.empty()) what.push_back("the file of " + file.filter + " " + file.name);
  }
  const std::vector<std::string> one = bytesMade(1, known);
  EXPECT_EQ(tested, known) << "all filters that there are";
  ASSERT_EQ(one.size(), what.size());
  for (size_t i = 0; i < one.size(); i++)
    EXPECT_GT(one[i].size(), what[i].starts_with("the file") ? 1000u : 10u) << what[i];
  for (const int ranks : {3, 8}) {
    const std::vector<std::string> many = bytesMade(ranks, known);
    ASSERT_EQ(many.size(), one.size());
    for (size_t i = 0; i < one.size(); i++)
      EXPECT_TRUE(many[i] == one[i]) << what[i] << " differs on " << ranks << " ranks"
                                     << (what[i].starts_with("the file") ? "" : ": " + many[i] + one[i]);
  }
}

}  // namespace
}  // namespace gxy::test
