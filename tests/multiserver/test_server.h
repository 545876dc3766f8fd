// SPDX-License-Identifier: Apache-2.0
// A server whose ranks are threads of this process, its data, and clients of it.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/comm/in_process.h"
#include "multiserver/client/client.h"
#include "multiserver/server/server.h"
#include "tests/support/temporary_folder.h"

namespace gxy::test {

struct ServerSetup {
  int ranks = 2;
  std::string modules;  ///< a folder to look into first; empty: none
  ServerRankOptions serverRank{};
  ServerOptions server{};
  std::map<std::string, std::string> tokens{};  ///< tenant by token; none: --no-token
  BackendRegistry::Maker backend{};             ///< called for each rank in turn; none: Embree
};

/// Runs while it lives. folder() is its only data folder; in it is ball.vol, 16^3 distances from the middle of [-1, 1]^3.
class TestServer {
 public:
  explicit TestServer(ServerSetup setup);
  ~TestServer();

  uint16_t port() const { return server_->port(); }
  const TemporaryFolder& folder() const { return folder_; }
  ServerRank& serverRank(int rank = 0) { return *nodes_[size_t(rank)]; }
  Server& server() { return *server_; }
  bool stopAsked() const { return stopAsked_; }
  /// Waits for it, a minute at most; whether it came.
  bool waitForStop() const;
  /// Ends the server and its nodes, as gxyserver does.
  void stop();

  /// A client that needs no token.
  Client::Options options(const std::string& tenant = "user") const;
  std::unique_ptr<Client> client(const std::string& tenant = "user") const;

 private:
  TemporaryFolder folder_;
  std::atomic<bool> stopAsked_ = false;
  std::unique_ptr<InProcessWorld> world_;
  std::vector<std::unique_ptr<ServerRank>> nodes_;
  std::unique_ptr<Server> server_;
};

/// Writes a volume of n^3 floats on [-1, 1]^3, value scale * (distance from 0), as NAME.vol and NAME.raw.
void writeBall(const std::string& folder, const std::string& name, int n, float scale = 1);

/// `import` of ball.vol under a name.
std::string importBall(const std::string& name, const std::string& file = "ball.vol");

/// A visualization document of a dataset: volume rendered, with an isosurface.
std::string stateOf(const std::string& dataset);

/// The progress that a client is told of.
class Progress {
 public:
  /// The event callback of a client.
  void take(const nlohmann::json& event);
  /// Waits (at most a minute) until a request is done; all events of it.
  std::vector<nlohmann::json> waitFor(uint32_t request);
  bool none() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<uint32_t, std::vector<nlohmann::json>> events_;
};

/// What a window's client has got: pictures by level, and ends.
class Screen {
 public:
  /// The pixel callback of a client.
  void take(const protocol::PixelHeader& header, std::span<const std::byte> data);

  struct End {
    std::string status;
    nlohmann::json json;
  };
  /// Waits (at most a minute) for the end of a frame.
  End waitFor(uint32_t window, uint64_t frame);

  struct Picture {
    uint64_t frame = 0;
    uint32_t width = 0, height = 0, scale = 0, pass = 0;
    std::vector<uint8_t> rgba;
    uint64_t covered = 0;  ///< pixels that tiles have brought in this pass
  };
  /// The newest picture of a level.
  Picture picture(uint32_t window, uint32_t scale = 1) const;
  int ends(uint32_t window, uint64_t frame) const;
  std::string error() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::pair<uint32_t, uint64_t>, std::vector<End>> ends_;
  std::map<std::pair<uint32_t, uint32_t>, Picture> pictures_;
  std::string error_;
};

}  // namespace gxy::test
