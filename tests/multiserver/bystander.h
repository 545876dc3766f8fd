// SPDX-License-Identifier: Apache-2.0
// What tests of hostile clients have in common: somebody who must not notice them, and what is left of them.
#pragma once
#include <gtest/gtest.h>

#include <dirent.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/multiserver/test_server.h"

namespace gxy::test {

/// Somebody who only wants pictures, and who must not notice the others.
class Bystander {
 public:
  explicit Bystander(const TestServer& server) {
    auto options = server.options("bystander");
    options.onPixels = [this](const auto& header, auto data) { screen_.take(header, data); };
    client_ = std::make_unique<Client>(options);
    client_->expect("load data");
    client_->expect("load viewer");
    client_->expect(importBall("ball"));
    client_->expect("window 1 {\"size\": [64, 48]}");
    client_->expect("set 1 " + stateOf("ball"));
    expected_ = picture();
  }
  void expectTheSamePicture() { EXPECT_EQ(picture(), expected_); }
  Client& client() { return *client_; }

 private:
  std::vector<uint8_t> picture() {
    const uint64_t frame = client_->expect("render 1").at("frame");
    EXPECT_EQ(screen_.waitFor(1, frame).status, "complete");
    return screen_.picture(1).rgba;
  }
  Screen screen_;
  std::unique_ptr<Client> client_;
  std::vector<uint8_t> expected_;
};

/// Waits until the server has no other clients than so many.
inline void waitForClients(TestServer& server, size_t n) {
  for (int i = 0; i < 3000 && server.server().clients() > n; i++)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(server.server().clients(), n);
}

inline int entriesOf(const char* folder) {
  int n = 0;
  DIR* dir = opendir(folder);
  while (readdir(dir)) n++;
  closedir(dir);
  return n;
}
/// Of this process.
inline int openFiles() { return entriesOf("/proc/self/fd"); }
inline int runningThreads() { return entriesOf("/proc/self/task"); }

/// The number after an argument of the test program as `--cycles=`; or what there is without one.
inline int argument(const std::string& name, int otherwise) {
  for (const std::string& arg : ::testing::internal::GetArgvs())
    if (arg.starts_with(name)) return std::stoi(arg.substr(name.size()));
  return otherwise;
}

}  // namespace gxy::test
