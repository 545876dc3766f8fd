// SPDX-License-Identifier: Apache-2.0
// A server with module viewer, and a client that looks at something.
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/multiserver/test_server.h"

namespace gxy::test {

inline std::unique_ptr<TestServer> serve(int ranks = 2) {
  ServerSetup setup;
  setup.ranks = ranks;
  setup.modules = GALAXY_MODULES;
  return std::make_unique<TestServer>(std::move(setup));
}

/// A client with a window, 1, of 96 x 80 pixels that shows a ball.
struct Viewer {
  explicit Viewer(const TestServer& server, const std::string& tenant = "user") {
    auto options = server.options(tenant);
    options.onPixels = [this](const auto& header, auto data) { screen.take(header, data); };
    options.onEvent = [this](const nlohmann::json& event) {
      if (event.at("event") != "error") return;
      const std::lock_guard lock(mutex);
      errors.push_back(event);
    };
    client = std::make_unique<Client>(options);
    client->expect("load data");
    client->expect("load viewer");
    if (client->expect("list").at("datasets").empty()) client->expect(importBall("ball"));
    client->expect("window 1 {\"size\": [96, 80]}");
    client->expect("set 1 " + stateOf("ball"));
  }
  uint64_t render(const std::string& options = "") {
    return client->expect("render 1 " + options).at("frame");
  }
  Screen::Picture frame(const std::string& options = "") {
    const auto end = screen.waitFor(1, render(options));
    EXPECT_EQ(end.status, "complete") << end.json;
    return screen.picture(1);
  }

  void makeWindow(const std::string& id, const std::string& settings, const std::string& dataset) {
    client->expect("window " + id + " " + settings);
    client->expect("set " + id + " " + stateOf(dataset));
  }
  nlohmann::json newestFrame(size_t window) {
    return client->expect("windows").at("windows").at(window - 1).at("frame");
  }
  // Of frames that the server would have started by itself, since the last call.
  std::vector<nlohmann::json> takeErrors() {
    const std::lock_guard lock(mutex);
    return std::exchange(errors, {});
  }

  Screen screen;
  std::mutex mutex;
  std::vector<nlohmann::json> errors;
  std::unique_ptr<Client> client;  // after what it uses, so that it goes first
};

/// Waits for what others do; only a failure takes the whole minute.
inline void until(const std::function<bool()>& condition, const char* what) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << "after a minute, not yet: " << what;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace gxy::test
