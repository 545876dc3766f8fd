// SPDX-License-Identifier: Apache-2.0
// There is one interpolation: at the same place, Interpolate, samplers, lines and `pick` tell the same value.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/multiserver/datasets_on_ranks.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A server with a field `v` whose samples are whole numbers, on a grid with a spacing of 1/8, and with the flow `flow`.
struct OneField {
  OneField() : server(serve(3)), viewer(*server) {
    viewer.client->expect("load analysis");
    writeBall(server->folder().path().string(), "grid", 17);
    viewer.client->expect(importBall("grid", "grid.vol"));
    make("Derive", "v", {{"f", "grid"}}, {{"expression", "64 * x * y - 32 * z + 128 * x * z * y + 0 * f"}});
    make("Derive", "east", {{"f", "grid"}}, {{"expression", "[1 + 0 * f, 0 * f, 0 * f]"}});
    make("Derive", "flow", {{"f", "grid"}}, {{"expression", "[0.2 * z - y, x, 0.3 * cos(4 * x)]"}});
    make("Seeds", "seeds", {{"domain", "grid"}}, {{"dimensions", {32, 16, 8}}});
  }
  json make(const std::string& filter, const std::string& name, const json& inputs, json properties) {
    properties.update({{"name", name}, {"filter", filter}, {"inputs", inputs}});
    return viewer.client->expect("make " + properties.dump()).at("results").at(0);
  }
  /// Expects that the points of a dataset have as values what Interpolate says of `v` there, up to `tolerance`.
  void expectInterpolated(const std::string& name, size_t least, float tolerance) {
    SCOPED_TRACE(name);
    make("Interpolate", "expected", {{"points", name}, {"fields", "v"}}, json::object());
    const GeometryBlock found = gathered(*server, name), expected = gathered(*server, "expected");
    ASSERT_GE(found.points.size(), least);
    ASSERT_EQ(found.points, expected.points);
    ASSERT_EQ(found.values.size(), expected.values.size());
    float worst = 0, largest = 0;
    for (size_t i = 0; i < found.values.size(); i++) {
      ASSERT_FALSE(std::isnan(found.values[i])) << i;
      worst = std::max(worst, std::abs(found.values[i] - expected.values[i]));
      largest = std::max(largest, std::abs(found.values[i]));
    }
    EXPECT_LE(worst, tolerance);
    EXPECT_GT(largest, 8) << "there is something to see";
  }

  std::unique_ptr<TestServer> server;
  Viewer viewer;
};

// Where no operation rounds, all have the same bits.
TEST(OneInterpolation, HasTheSameBitsWhereNothingIsRounded) {
  OneField one;
  one.make("Interpolate", "plain", {{"points", "seeds"}, {"fields", "v"}}, json::object());
  const GeometryBlock plain = gathered(*one.server, "plain");
  ASSERT_EQ(plain.points.size(), 4096u);
  for (size_t i = 0; i < plain.points.size(); i++) {
    const glm::dvec3 p = plain.points[i];
    ASSERT_EQ(plain.values[i], 64 * p.x * p.y - 32 * p.z + 128 * p.x * p.z * p.y);
  }
  one.make("StreamTracer", "ends", {{"vectors", "east"}, {"seeds", "seeds"}, {"field", "v"}, {"fields", "v"}},
           {{"time", 0.03125}, {"points", "ends"}, {"color by", "field"}});
  one.expectInterpolated("ends", 8000, 0);
  one.make("RaySampler", "rays", {{"f", "v"}, {"s", "seeds"}},
           {{"operators", {{{"dataset", "f"}, {"every", 0.03125}, {"hits", 1}}}},
            {"points", "s"},
            {"direction", {0, 0, 1}},
            {"values", "f"}});
  one.expectInterpolated("rays", 4000, 0);
}

// A value is a sum of eight samples of up to 224: what rounding of float leaves is two of their ulps at most.
TEST(OneInterpolation, IsTheSameUpToRoundingAnywhere) {
  OneField one;
  constexpr float kUlp = 224 * 0x1p-23F;
  one.make("IsosurfaceSampler", "surface", {{"field", "grid"}, {"values", "v"}},
           {{"isovalue", 0.7}, {"count", 2000}});
  one.expectInterpolated("surface", 2000, 2 * kUlp);
  one.make("DensitySampler", "density", {{"field", "v"}}, {{"count", 2000}});
  one.expectInterpolated("density", 2000, 2 * kUlp);
  one.make("RaySampler", "rays", {{"f", "v"}},
           {{"operators", {{{"dataset", "f"}, {"every", 0.1}}}}, {"lines", 300}, {"values", "f"}});
  one.expectInterpolated("rays", 1000, 2 * kUlp);
  one.make("StreamTracer", "lines",
           {{"vectors", "flow"}, {"seeds", "seeds"}, {"field", "v"}, {"fields", "v"}},
           {{"time", 0.5}, {"color by", "field"}});
  one.expectInterpolated("lines", 10000, 2 * kUlp);
  // The further fields of lines are Interpolate's to the bit.
  const GeometryBlock lines = gathered(*one.server, "lines"), expected = gathered(*one.server, "expected");
  const PointField* field = findField(lines.fields, "v");
  ASSERT_NE(field, nullptr);
  ASSERT_EQ(field->values.size(), expected.values.size());
  EXPECT_EQ(
      0, std::memcmp(field->values.data(), expected.values.data(), expected.values.size() * sizeof(float)));
}

TEST(OneInterpolation, IsWhatPickTells) {
  OneField one;
  Client& client = *one.viewer.client;
  client.expect(
      R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "v", "slices": [[1, 2, -3, 0.1]]}]},
    "Camera": {"viewpoint": [3, 2, -4], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 30}})");
  json points = json::array();
  std::vector<double> values;
  for (int x = 0; x < 96; x += 7)
    for (int y = 0; y < 80; y += 7) {
      const json picked = client.expect("pick 1 " + std::to_string(x) + " " + std::to_string(y));
      if (!picked.at("hit").get<bool>()) continue;
      points.push_back(picked.at("point"));
      values.push_back(picked.at("value"));
    }
  ASSERT_GT(values.size(), 30u);
  one.make("Seeds", "picked", {{"domain", "v"}}, {{"shape", "points"}, {"points", points}});
  one.make("Interpolate", "expected", {{"points", "picked"}, {"fields", "v"}}, json::object());
  const GeometryBlock expected = gathered(*one.server, "expected");
  ASSERT_EQ(expected.values.size(), values.size());
  double worst = 0;
  for (size_t i = 0; i < values.size(); i++)
    worst = std::max(worst, std::abs(values[i] - double(expected.values[i])));
  EXPECT_LE(worst, 224 * 0x1p-23);
}

}  // namespace
}  // namespace gxy::test
