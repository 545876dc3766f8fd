// SPDX-License-Identifier: Apache-2.0
// Simulations that publish particles: what arrives is what an import of the same step would give.
#include <numeric>

#include "core/io/write_geometry.h"
#include "tests/insitu/published.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// Particle `id` of a step.
glm::dvec3 positionOf(uint64_t id, int64_t step) {
  const double a = 0.7 * double(id), t = 0.1 * double(step);
  return {std::sin(a + t), std::cos(1.3 * a - t), std::sin(2.1 * a) + 0.01 * t};
}
double massOf(uint64_t id, int64_t step) { return double(id % 17) + 0.25 * double(step); }
glm::dvec3 velocityOf(uint64_t id) { return {double(id % 3), double(id % 5), -1}; }

/// Particles that change their ranks at each step, in arrays of structures. All ranks publish on one thread.
class MiniParticles {
 public:
  struct Settings {
    int ranks = 2;
    uint64_t count = 100;
    bool floats = false;  ///< positions are floats
    int ids = GXY_INT64;  ///< their type; -1: none, and the particles stay in the order of ranks
    bool fields = true;   ///< mass, velocity, and colours
    const double* box = nullptr;
  };
  MiniParticles(const TestServer& server, const Settings& settings, uint64_t seed)
      : settings_(settings), random_(seed) {
    for (int r = 0; r < settings.ranks; r++)
      ranks_.push_back({gxy_open("cloud", r, settings.ranks, to(server).c_str()), {}});
  }
  ~MiniParticles() {
    for (const Rank& r : ranks_) gxy_close(r.sim, 0);
  }
  MiniParticles(const MiniParticles&) = delete;
  MiniParticles& operator=(const MiniParticles&) = delete;

  gxy_sim* rank(int r) { return ranks_[size_t(r)].sim; }
  int64_t published() {
    gxy_stat statistics{};
    gxy_statistics(rank(0), &statistics);
    return statistics.published;
  }
  /// Other particles than those of the settings in the next steps.
  std::function<void(std::vector<uint64_t>& ids)> change = [](std::vector<uint64_t>&) {};

  void publish() {
    step_++;
    std::vector<uint64_t> ids(settings_.count);
    std::iota(ids.begin(), ids.end(), uint64_t(0));
    change(ids);
    for (Rank& r : ranks_) r.particles.clear();
    for (size_t i = 0; i < ids.size(); i++) {
      const size_t rank = settings_.ids < 0 ? i * ranks_.size() / ids.size() : random_.below(ranks_.size());
      ranks_[rank].particles.push_back(particle(ids[i]));
    }
    for (Rank& r : ranks_) {
      if (settings_.ids >= 0)
        for (size_t i = r.particles.size(); i > 1; i--)
          std::swap(r.particles[i - 1], r.particles[random_.below(i)]);
      tell(r);
      EXPECT_NE(gxy_publish(r.sim, step_, 0.5 * double(step_)), GXY_WRONG) << gxy_message(r.sim);
    }
  }

 private:
  struct Particle {
    double position[3];
    float near[3];
    int64_t id;
    int32_t shortId;
    double mass;
    float velocity[3];
    uint8_t paint[3];
  };
  struct Rank {
    gxy_sim* sim;
    std::vector<Particle> particles;
  };
  Particle particle(uint64_t id) const {
    const glm::dvec3 p = positionOf(id, step_), v = velocityOf(id);
    return {{p.x, p.y, p.z},
            {float(p.x), float(p.y), float(p.z)},
            int64_t(id),
            int32_t(id),
            massOf(id, step_),
            {float(v.x), float(v.y), float(v.z)},
            {uint8_t(100 + id % 150), uint8_t(100 + step_ % 150), 7}};
  }
  void tell(Rank& r) const {
    const Particle* all = r.particles.data();
    const auto array = [&](const void* first, int type, int components) {
      return gxy_array{
          r.particles.empty() ? nullptr : first, type, components, {sizeof(Particle), 0, 0}, 0, 0};
    };
    const gxy_array positions =
        settings_.floats ? array(all->near, GXY_FLOAT32, 3) : array(all->position, GXY_FLOAT64, 3);
    const gxy_array ids = settings_.ids < 0            ? gxy_array{}
                          : settings_.ids == GXY_INT64 ? array(&all->id, GXY_INT64, 1)
                                                       : array(&all->shortId, GXY_INT32, 1);
    EXPECT_EQ(gxy_points(r.sim, "atoms", int64_t(r.particles.size()), positions, ids, settings_.box),
              GXY_TAKEN)
        << gxy_message(r.sim);
    if (!settings_.fields) return;
    EXPECT_EQ(gxy_field(r.sim, "atoms", 0, "mass", GXY_OF_POINTS, array(&all->mass, GXY_FLOAT64, 1)),
              GXY_TAKEN);
    EXPECT_EQ(gxy_field(r.sim, "atoms", 0, "velocity", GXY_OF_POINTS, array(all->velocity, GXY_FLOAT32, 3)),
              GXY_TAKEN);
    EXPECT_EQ(gxy_field(r.sim, "atoms", 0, "paint", GXY_OF_POINTS, array(all->paint, GXY_UINT8, 3)),
              GXY_TAKEN);
  }

  const Settings settings_;
  Random random_;
  std::vector<Rank> ranks_;
  int64_t step_ = 0;
};

/// Compares a dataset with an import of a file that has the same particles.
void expectEqualsImport(TestServer& server, Viewer& viewer, const std::string& name, bool floats) {
  const auto published = datasetOn(server, 0, name);
  const int64_t step = published->origins.at(0).step;
  const std::string field = published->array;
  GeometryBlock block;
  for (uint64_t id = 0; id < published->geometry->primitives; id++) {
    const glm::dvec3 p = positionOf(id, step);
    block.points.push_back(floats ? glm::dvec3(glm::vec3(p)) : p);
    block.ids.push_back(id);
    const glm::dvec3 v = velocityOf(id);
    if (field == "mass") block.values.push_back(float(massOf(id, step)));
    if (field == "paint")
      block.colors.push_back(
          {float(double(100 + id % 150) / 255), float(double(100 + step % 150) / 255), float(7. / 255)});
    if (field == "velocity") block.values.push_back(float(std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z)));
  }
  writeGeometry(server.folder().path().string() + "/file.vtp", block, GeometryKind::Particles, "values");
  viewer.client->expect(
      "import like " + name + " " +
      json{{"Datasets", {{{"name", "file"}, {"filename", "file.vtp"}, {"type", "Particles"}}}}}.dump());
  const auto imported = datasetOn(server, 0, "file");
  const OwnedGeometry &a = *published->geometry, &b = *imported->geometry;
  EXPECT_EQ(a.box, b.box);
  EXPECT_EQ(a.middle, b.middle);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.range, b.range);
  EXPECT_EQ(a.colored, b.colored);
  EXPECT_EQ(a.primitives, b.primitives);
  EXPECT_EQ(gathered(server, name), gathered(server, "file"));
  EXPECT_EQ(published->time, 0.5 * double(step));
  const auto picture = [&](const std::string& dataset) {
    viewer.client->expect(
        "set 1 " +
        json{
            {"Visualization",
             {{"operators",
               {{{"type", "Particles"}, {"dataset", dataset}, {"radius", "auto"}, {"data range", "data"}}}}}},
            {"Camera", {{"fit", true}}}}
            .dump());
    return viewer.frame().rgba;
  };
  const auto found = picture(name), expected = picture("file");
  EXPECT_TRUE(found == expected) << "the pictures of " << name << " differ";
  EXPECT_GT(std::count_if(found.begin(), found.end(), [](uint8_t v) { return v > 60 && v < 255; }), 100);
}

TEST(Particles, ThatArePublishedEqualTheImportOfTheSameStep) {
  for (uint64_t seed = 1; seed <= uint64_t(sweep(8)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const auto server = serve(1 + int(random.below(3)));
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    MiniParticles::Settings settings;
    settings.ranks = 1 + int(random.below(6));
    settings.count = seed == 1 ? 1 : 50 + random.below(3000);
    settings.floats = random.oneIn(2);
    settings.ids = seed % 3 == 0 ? -1 : seed % 3 == 1 ? GXY_INT64 : GXY_INT32;
    settings.fields = seed % 4 != 0;
    const double box[6] = {-2, -2, -2, 3, 3, 3};
    if (settings.count == 1 || random.oneIn(2)) settings.box = box;
    {
      MiniParticles particles(*server, settings, seed);
      viewer.client->expect("observe");
      run(particles, [&] { return particles.published() >= 2; });
    }
    until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
          "the end of the stream");
    if (!settings.fields) {
      expectEqualsImport(*server, viewer, "cloud.atoms", settings.floats);
      continue;
    }
    expectEqualsImport(*server, viewer, "cloud.mass", settings.floats);
    expectEqualsImport(*server, viewer, "cloud.velocity", settings.floats);
    expectEqualsImport(*server, viewer, "cloud.paint", settings.floats);
    EXPECT_EQ(datasetOn(*server, 0, "cloud.mass")->origins, datasetOn(*server, 0, "cloud.velocity")->origins);
  }
}

TEST(Particles, MayComeAndGoAndThoseThatAreNowhereAreLeftOut) {
  const auto server = serve(2);
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniParticles particles(*server, {}, 1);
  run(particles, [&] { return particles.published() >= 1; });
  const auto expect = [&](uint64_t count) {
    const int64_t before = particles.published();
    run(particles, [&] { return particles.published() >= before + 2; });
    EXPECT_EQ(datasetOn(*server, 0, "cloud.mass")->geometry->primitives, count);
  };
  particles.change = [](auto& ids) { ids.resize(7); };
  expect(7);
  particles.change = [](auto& ids) { ids.clear(); };
  expect(0);
  particles.change = [](auto& ids) { ids.resize(5000), std::iota(ids.begin(), ids.end(), 900); };
  expect(5000);
}

TEST(Particles, OfWhichTwoHaveOneNumberAreLeftOutAndTold) {
  const auto server = serve(3);
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniParticles particles(*server, {}, 1);
  run(particles, [&] { return particles.published() >= 1; });
  const auto expectProblem = [&](const std::string& why) {
    run(particles, [&] {
      return client->expect("insitu.streams").at("streams").at(0).value("problem", "").find(why) !=
             std::string::npos;
    });
  };
  particles.change = [](auto& ids) { ids[3] = 71; };
  expectProblem("points \"atoms\": two of them have the number 71");
  particles.change = [](auto& ids) { ids[3] = uint64_t(-5); };
  expectProblem("the number -5 of a point is negative");
  particles.change = [](auto&) {};
  const int64_t before = particles.published();
  run(particles, [&] { return particles.published() > before; });
}

TEST(Particles, ForWhichThereIsNoRoomAreLeftOutAndTheServerGoesOn) {
  ServerSetup setup;
  setup.ranks = 2;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1 << 20;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniParticles particles(server, {}, 1);
  run(particles, [&] { return particles.published() >= 1; });
  particles.change = [](auto& ids) { ids.resize(100000), std::iota(ids.begin(), ids.end(), uint64_t(0)); };
  expectTooLittleRoomAndThenSteps(particles, *client);
}

TEST(Particles, AreShownTogetherWithAGridOfTheirSimulation) {
  const auto server = serve(2);
  const auto client = server->client();
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({9, 10, 11});
  gxy_sim* sim = gxy_open("both", 0, 1, to(*server).c_str());
  MiniArray t({"t"}, {{0, 0, 0}, grid.points}, Layout::Ghosts);
  const int64_t first[3] = {0, 0, 0};
  const float at[6] = {0, 1, 3, -0.5F, 0.5F, 100};
  EXPECT_EQ(gxy_grid(sim, "grid", 0, GXY_OF_POINTS, grid.points.data(), first, grid.points.data(),
                     &grid.origin[0], &grid.spacing[0]),
            GXY_TAKEN);
  EXPECT_EQ(gxy_field(sim, "grid", 0, "t", GXY_OF_POINTS, t.array()), GXY_TAKEN);
  EXPECT_EQ(gxy_points(sim, "atoms", 2, {at, GXY_FLOAT32, 3, {12, 0, 0}, 0, 0}, {}, nullptr), GXY_TAKEN);
  int64_t step = 0;
  gxy_stat statistics{};
  until(
      [&] {
        t.fill(grid, ++step, 0);
        EXPECT_NE(gxy_publish(sim, step, 0), GXY_WRONG) << gxy_message(sim);
        gxy_statistics(sim, &statistics);
        return statistics.published >= 2;
      },
      "two steps");
  gxy_close(sim, 5);
  const auto field = datasetOn(*server, 0, "both.t"), atoms = datasetOn(*server, 0, "both.atoms");
  EXPECT_EQ(field->origins, atoms->origins);
  EXPECT_EQ(*field->partitioning, *atoms->partitioning);
  EXPECT_EQ(atoms->geometry->primitives, 2u);
  EXPECT_EQ(atoms->geometry->box.hi.z, 100) << "outside the grid";
}

}  // namespace
}  // namespace gxy::test
