// SPDX-License-Identifier: Apache-2.0
// What a server has of a stream, compared with an import of the same step.
#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/data/dataset.h"
#include "core/io/write_volume.h"
#include "multiserver/server/datasets.h"
#include "tests/insitu/mini_simulation.h"
#include "tests/multiserver/datasets_on_ranks.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {

/// Options that publish to a server.
inline std::string to(const TestServer& server, double reconnect = 0.05) {
  return nlohmann::json{
      {"to", "127.0.0.1:" + std::to_string(server.port())}, {"token-file", "-"}, {"reconnect", reconnect}}
      .dump();
}

/// The same of a simulation that waits for its steps, for so many seconds or, with null, as long as it takes.
inline std::string waiting(const TestServer& server, const nlohmann::json& timeOut) {
  nlohmann::json options = nlohmann::json::parse(to(server));
  options.update({{"policy", "wait"}, {"time-out", timeOut}});
  return options.dump();
}

/// Publishes steps of a simulation until `enough` says so.
template <class Simulation>
void run(Simulation& simulation, const std::function<bool()>& enough) {
  until(
      [&] {
        simulation.publish();
        return enough();
      },
      "enough steps");
}

/// Publishes steps until one is left out for want of memory, undoes what made it too large (`change`), and publishes until a step is
/// published again.
template <class Simulation>
void expectTooLittleRoomAndThenSteps(Simulation& simulation, Client& client) {
  run(simulation, [&] {
    const nlohmann::json stream = client.expect("insitu.streams").at("streams").at(0);
    return stream.value("problem", "").find("bytes are needed") != std::string::npos;
  });
  simulation.change = [](auto&) {};
  const int64_t before = simulation.published();
  run(simulation, [&] { return simulation.published() > before; });
}

inline Grid gridOf(const Index3& points) {
  Grid grid;
  grid.points = points;
  grid.origin = {-1, 0.25, 2};
  grid.spacing = {0.125, 0.1, 0.3};
  return grid;
}

/// Events about a dataset that a client is told.
class Events {
 public:
  explicit Events(std::string dataset) : dataset_(std::move(dataset)) {}
  std::unique_ptr<Client> client(const TestServer& server) {
    auto options = server.options();
    options.onEvent = [this](const nlohmann::json& event) {
      const std::lock_guard lock(mutex_);
      if (event.value("name", "") == dataset_) events_.push_back(event);
    };
    return std::make_unique<Client>(options);
  }
  std::vector<nlohmann::json> all() const {
    const std::lock_guard lock(mutex_);
    return events_;
  }
  size_t count(const std::string& kind) const {
    const std::lock_guard lock(mutex_);
    return size_t(std::count_if(events_.begin(), events_.end(),
                                [&](const nlohmann::json& e) { return e.at("event") == kind; }));
  }

 private:
  const std::string dataset_;
  mutable std::mutex mutex_;
  std::vector<nlohmann::json> events_;
};

/// What files say of a grid that counts cells.
inline Grid centresOf(Grid grid) {
  grid.rim = true;
  for (int a = 0; a < 3; a++) {
    grid.points[size_t(a)] += 2;
    grid.origin[a] -= grid.spacing[a] / 2;
  }
  return grid;
}

/// Writes a step of a field of points or cells as a file, and returns its name.
inline std::string writeStep(const TestServer& server, const Grid& grid, int of, const MiniField& field,
                             size_t number, int64_t step) {
  const bool cells = of == GXY_OF_CELLS;
  const std::string name = field.name + (cells ? ".vti" : ".json");
  const VolumeWriter writer(server.folder().path().string() + "/" + name, cells ? centresOf(grid) : grid,
                            {{field.name, field.type, field.components, std::nullopt, cells}});
  for (int64_t k = 0; k < grid.points[2]; k++) {
    Bytes slice;
    for (int64_t j = 0; j < grid.points[1]; j++)
      for (int64_t i = 0; i < grid.points[0]; i++)
        for (int c = 0; c < field.components; c++)
          withType(field.type, [&](auto value) {
            value = decltype(value)(valueAt(grid, {i, j, k}, step, number, c));
            const auto* bytes = reinterpret_cast<const std::byte*>(&value);
            slice.insert(slice.end(), bytes, bytes + sizeof value);
          });
    writer.write(0, k, slice);
  }
  return name;
}

/// Compares what is published on all ranks with an import of the same step.
inline void expectEqualsImport(TestServer& server, Client& client, const Grid& grid, int of,
                               const std::vector<MiniField>& fields) {
  const int64_t step = datasetOn(server, 0, "heat." + fields[0].name)->origins.at(0).step;
  for (size_t f = 0; f < fields.size(); f++) {
    const std::string name = "heat." + fields[f].name, file = writeStep(server, grid, of, fields[f], f, step);
    client.expect(
        "import like " + name + " " +
        nlohmann::json{{"Datasets", {{{"name", "file"}, {"filename", file}, {"type", "Volume"}}}}}.dump());
    for (int r = 0; r < server.serverRank().ranks(); r++) {
      const auto found = datasetOn(server, r, name), expected = datasetOn(server, r, "file");
      EXPECT_EQ(found->origins.at(0).step, step) << "all fields are of one step";
      EXPECT_EQ(found->time, 0.5 * double(step));
      EXPECT_EQ(found->bytes, expected->bytes);
      EXPECT_EQ(found->memory.bytes(), expected->memory.bytes());
      expectSame(*found->volume, *expected->volume);
    }
  }
}

}  // namespace gxy::test
