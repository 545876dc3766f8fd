// SPDX-License-Identifier: Apache-2.0
#include "tests/multiserver/test_server.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <thread>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"
#include "multiserver/protocol/tile_codec.h"

namespace gxy::test {

TestServer::TestServer(ServerSetup setup) {
  spdlog::set_level(spdlog::level::err);
  writeBall(folder_.path().string(), "ball", 16);
  InProcessWorld::Options world;
  world.threaded = true;
  world_ = std::make_unique<InProcessWorld>(setup.ranks, 1, world);
  BackendRegistry backends;
  if (!setup.backend) setup.backend = [](Ledger*) { return makeEmbreeBackend(); };
  backends.add("tested", setup.backend);
  backends.addForFields([](Ledger*) { return makeEmbreeBackend(); });
  auto& folders = setup.serverRank.moduleFolders;
  if (!setup.modules.empty()) folders.insert(folders.begin(), setup.modules);
  setup.serverRank.dataFolders = {folder_.path().string()};
  for (int r = 0; r < setup.ranks; r++)
    nodes_.push_back(std::make_unique<ServerRank>(world_->rank(r), setup.serverRank, backends));
  for (const auto& [token, tenant] : setup.tokens)
    serverRank().tenants.add(token, {tenant, tenant == "admin"});
  if (setup.tokens.empty()) serverRank().tenants.admitAll();
  setup.server.port = 0;
  setup.server.signals = false;
  server_ = std::make_unique<Server>(serverRank(), setup.server, [this] { stopAsked_ = true; });
}

TestServer::~TestServer() { stop(); }

bool TestServer::waitForStop() const {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!stopAsked_ && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return stopAsked_;
}

void TestServer::stop() {
  server_.reset();
  if (world_) world_->run();
  nodes_.clear();
  world_.reset();
}

Client::Options TestServer::options(const std::string& tenant) const {
  Client::Options options;
  options.port = port();
  options.tokenFile = "-";
  options.tenant = tenant;
  options.name = "test";
  return options;
}

std::unique_ptr<Client> TestServer::client(const std::string& tenant) const {
  return std::make_unique<Client>(options(tenant));
}

void writeBall(const std::string& folder, const std::string& name, int n, float scale) {
  std::vector<float> samples;
  const auto at = [n](int i) { return -1 + 2.0 * i / (n - 1); };
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        samples.push_back(scale * float(std::sqrt(at(i) * at(i) + at(j) * at(j) + at(k) * at(k))));
  std::ofstream raw(folder + "/" + name + ".raw", std::ios::binary);
  raw.write(reinterpret_cast<const char*>(samples.data()), std::streamsize(samples.size() * sizeof(float)));
  const std::string d = std::to_string(2.0 / (n - 1)), c = std::to_string(n);
  std::ofstream(folder + "/" + name + ".vol") << "float\n-1 -1 -1\n"
                                              << c << " " << c << " " << c << "\n"
                                              << d << " " << d << " " << d << "\n"
                                              << name << ".raw\n";
}

std::string importBall(const std::string& name, const std::string& file) {
  return R"(import {"Datasets": [{"name": ")" + name + R"(", "filename": ")" + file +
         R"(", "type": "Volume"}]})";
}

std::string stateOf(const std::string& dataset) {
  return R"({"Visualization": {"Lighting": {"shadows": true, "ao count": 2, "ao radius": 0.5},
    "operators": [{"type": "Volume", "dataset": ")" +
         dataset +
         R"(", "isovalues": [0.6], "volume rendering": true, "colormap": "Viridis", "data range": [0, 1.7],
    "extinctionmap": [[0, 0], [0.8, 0.5], [1.7, 2]]}]},
    "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "aov": 30, "dimensions": [96, 80]}})";
}

void Progress::take(const nlohmann::json& event) {
  if (event.at("event") != "progress") return;
  const std::lock_guard lock(mutex_);
  events_[event.at("request")].push_back(event);
  changed_.notify_all();
}

std::vector<nlohmann::json> Progress::waitFor(uint32_t request) {
  std::unique_lock lock(mutex_);
  const std::vector<nlohmann::json>& events = events_[request];
  if (!changed_.wait_for(lock, std::chrono::minutes(1), [&] {
        return !events.empty() && events.back().at("done") == events.back().at("of");
      }))
    throw Error("request " + std::to_string(request) + " is not done");
  return events;
}

bool Progress::none() const {
  const std::lock_guard lock(mutex_);
  return events_.empty();
}

void Screen::take(const protocol::PixelHeader& header, std::span<const std::byte> data) {
  const std::lock_guard lock(mutex_);
  try {
    if (header.kind == protocol::PixelKind::EndOfFrame) {
      const auto json =
          nlohmann::json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
      ends_[{header.window, header.frame}].push_back({json.at("status"), json});
      changed_.notify_all();
      return;
    }
    if (header.kind != protocol::PixelKind::Tile) return;
    const protocol::TilePixels tile = protocol::decodeTile(header, data);
    const size_t channels = tile.format == protocol::PixelFormat::Rgba8 ? 4 : 3;
    Picture& p = pictures_[{header.window, header.scale}];
    if (p.frame != header.frame || p.pass != header.pass || p.width != header.width ||
        p.height != header.height) {
      p = {header.frame, header.width, header.height, header.scale, header.pass, {}, 0};
      p.rgba.assign(size_t(p.width) * p.height * 4, 0);
    }
    for (uint32_t y = 0; y < header.h; y++)
      for (uint32_t x = 0; x < header.w; x++)
        for (size_t c = 0; c < 4; c++)
          p.rgba[((size_t(header.y) + y) * p.width + header.x + x) * 4 + c] =
              c < channels ? tile.bytes[(size_t(y) * header.w + x) * channels + c] : uint8_t(255);
    p.covered += uint64_t(header.w) * header.h;
  } catch (const std::exception& e) {
    error_ = e.what();
  }
}

Screen::End Screen::waitFor(uint32_t window, uint64_t frame) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, std::chrono::minutes(1), [&] { return ends_.count({window, frame}) > 0; }))
    throw Error("frame " + std::to_string(frame) + " of window " + std::to_string(window) + " has no end");
  return ends_.at({window, frame}).front();
}

Screen::Picture Screen::picture(uint32_t window, uint32_t scale) const {
  const std::lock_guard lock(mutex_);
  const auto at = pictures_.find({window, scale});
  return at == pictures_.end() ? Picture{} : at->second;
}

int Screen::ends(uint32_t window, uint64_t frame) const {
  const std::lock_guard lock(mutex_);
  const auto at = ends_.find({window, frame});
  return at == ends_.end() ? 0 : int(at->second.size());
}

std::string Screen::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

}  // namespace gxy::test
