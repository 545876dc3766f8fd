// SPDX-License-Identifier: Apache-2.0
// A rank that does not answer.
#pragma once
#include <latch>
#include <memory>

#include "tests/multiserver/test_server.h"

namespace gxy::test {

/// A rank that takes no messages while this lives. The server may stop, and its transports go, while this ends.
class Hang {
 public:
  Hang(TestServer& server, int rank) {
    server.serverRank(rank).transport.onMessage(Channel::Test, [state = state_](int, Bytes) {
      state->begun.count_down();
      state->over.wait();
    });
    server.serverRank(0).transport.send(rank, Channel::Test, {});
    state_->begun.wait();
  }
  ~Hang() { state_->over.count_down(); }
  Hang(const Hang&) = delete;
  Hang& operator=(const Hang&) = delete;

 private:
  struct State {
    std::latch begun{1}, over{1};
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace gxy::test
