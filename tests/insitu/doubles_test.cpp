// SPDX-License-Identifier: Apache-2.0
// Doubles of simulations, which are sent as floats once their range is known.
#include <cfenv>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tests/insitu/published.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A simulation of one rank with one field of doubles, whose values are a wave with an amplitude around a middle.
class Doubles {
 public:
  explicit Doubles(const std::string& options, int components = 1, const Index3& points = {9, 8, 7})
      : grid_(gridOf(points)),
        components_(components),
        values_(size_t(points[0] * points[1] * points[2] * components)) {
    const int64_t *size = grid_.points.data(), first[3] = {0, 0, 0};
    sim_.reset(gxy_open("heat", 0, 1, options.c_str()));
    gxy_grid(sim_.get(), "grid", 0, GXY_OF_POINTS, size, first, size, &grid_.origin[0], &grid_.spacing[0]);
    const int64_t bytes = 8 * components;
    gxy_field(sim_.get(), "grid", 0, "p", GXY_OF_POINTS,
              {values_.data(),
               GXY_FLOAT64,
               components,
               {bytes, points[0] * bytes, points[0] * points[1] * bytes},
               0,
               0});
  }
  int publish(double middle, double amplitude) {
    step_++;
    for (size_t i = 0; i < values_.size(); i++)
      values_[i] = middle + amplitude * std::sin(double(i) + 0.1 * double(step_));
    for (size_t i = 5; i < values_.size(); i += 1009) values_[i] = i % 2 ? NAN : -INFINITY;
    kept_[step_] = values_;
    feenableexcept(FE_INVALID | FE_OVERFLOW | FE_DIVBYZERO);  // as many simulations do
    const int result = gxy_publish(sim_.get(), step_, 0.5 * double(step_));
    fedisableexcept(FE_ALL_EXCEPT);
    return result;
  }
  /// Publishes the same values until a step of them is published.
  void publishOne(double middle, double amplitude) {
    const int64_t before = statistics().published;
    until(
        [&] {
          publish(middle, amplitude);
          return statistics().published > before;
        },
        "a step");
  }
  gxy_stat statistics() const {
    gxy_stat s{};
    gxy_statistics(sim_.get(), &s);
    return s;
  }
  void close() { sim_.reset(); }
  /// Writes a step as a file of a server, and returns its name.
  std::string write(const TestServer& server, int64_t step) const {
    const VolumeWriter writer(server.folder().path().string() + "/p.json", grid_,
                              {{"p", ScalarType::Float64, components_, std::nullopt, false}});
    const size_t slice = values_.size() / size_t(grid_.points[2]);
    for (int64_t k = 0; k < grid_.points[2]; k++)
      writer.write(0, k, std::as_bytes(std::span(kept_.at(step)).subspan(size_t(k) * slice, slice)));
    return "p.json";
  }

 private:
  struct Close {
    void operator()(gxy_sim* s) const { gxy_close(s, 0); }
  };
  Grid grid_;
  int components_;
  std::vector<double> values_;
  std::map<int64_t, std::vector<double>> kept_;
  std::unique_ptr<gxy_sim, Close> sim_;
  int64_t step_ = 0;
};

void expectEqualsImport(TestServer& server, Client& client, const Doubles& simulation) {
  until(
      [&] {
        const json stream = client.expect("insitu.streams").at("streams").at(0);
        return simulation.statistics().taken ==
               stream.at("published").get<int64_t>() + stream.at("abandoned").get<int64_t>();
      },
      "the end of the step under way");
  const int64_t step = datasetOn(server, 0, "heat.p")->origins.at(0).step;
  const std::string file = simulation.write(server, step);
  client.expect("import like heat.p " +
                json{{"Datasets", {{{"name", "file"}, {"filename", file}, {"type", "Volume"}}}}}.dump());
  for (int r = 0; r < server.serverRank().ranks(); r++)
    expectSame(*datasetOn(server, r, "heat.p")->volume, *datasetOn(server, r, "file")->volume);
}

TEST(Doubles, AreSentAsFloatsOnceTheirRangeIsKnown) {
  for (const int components : {1, 3}) {
    SCOPED_TRACE(components);
    const auto server = serve();
    const auto client = server->client();
    client->expect("load data");
    client->expect("load insitu");
    client->expect("observe");
    Doubles simulation(to(*server), components);
    const int64_t whole = 9 * 8 * 7 * 8 * components;
    simulation.publishOne(101325, 20);
    for (int step = 1; step <= 300; step++) simulation.publishOne(101325 + 0.02 * step, 20 + 0.01 * step);
    const gxy_stat s = simulation.statistics();
    EXPECT_EQ(s.bytes, whole + (s.taken - 1) * whole / 2) << "the first as it is";
    const json stream = client->expect("insitu.streams").at("streams").at(0);
    EXPECT_LE(stream.at("abandoned"), 3) << "of 300";
    const auto volume = datasetOn(*server, 0, "heat.p")->volume;
    if (components == 1)
      EXPECT_NEAR(volume->shift, 101325, 64);
    else
      EXPECT_EQ(volume->shift, 0);
    expectEqualsImport(*server, *client, simulation);
  }
}

TEST(Doubles, PiecesOfManyChunksEqualTheImport) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  for (const int components : {3, 1}) {
    Doubles simulation(to(*server), components, {131, 41, 67});  // chunks end inside rows
    for (int steps = 1; steps <= 2; steps++) {                   // as doubles, and as floats
      simulation.publishOne(100, 20);
      expectEqualsImport(*server, *client, simulation);
    }
    simulation.close();
    until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
    for (const char* name : {"heat.p", "file"}) client->expect(std::string("drop ") + name);
  }
}

TEST(Doubles, OfAnotherRangeAreNotSentAsTheFloatsOfBefore) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  Doubles simulation(to(*server));
  const std::pair<double, double> jumps[] = {{101325, 20}, {-5e6, 3}, {1e300, 1e299}, {0, 1e-200},
                                             {1e39, 1},    {0, 1},    {7, 0}};
  for (const auto& [middle, amplitude] : jumps) {
    SCOPED_TRACE(middle);
    // Ten times as doubles, and afterwards as floats again.
    for (int n = 0; n < 13; n++) simulation.publishOne(middle, amplitude);
    expectEqualsImport(*server, *client, simulation);
  }
  const json stream = client->expect("insitu.streams").at("streams").at(0);
  EXPECT_GE(stream.at("abandoned"), 5);
  EXPECT_LE(stream.at("abandoned"), 7) << "one for each jump";
  EXPECT_GE(stream.at("published"), 7 * 13);
}

TEST(Doubles, OfASimulationThatWaitsStayDoubles) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  Doubles simulation(waiting(*server, nullptr));
  for (int step = 1; step <= 10; step++) EXPECT_EQ(simulation.publish(step % 3 ? 5 : 1e9, step), GXY_TAKEN);
  until([&] { return simulation.statistics().published == 10; }, "the last step");
  EXPECT_EQ(simulation.statistics().bytes, 10 * 9 * 8 * 7 * 8);
  EXPECT_EQ(client->expect("insitu.streams").at("streams").at(0).at("abandoned"), 0);
}

}  // namespace
}  // namespace gxy::test
