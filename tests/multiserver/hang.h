// SPDX-License-Identifier: Apache-2.0
// A rank that does not answer.
#pragma once
#include <latch>

#include "tests/multiserver/test_server.h"

namespace gxy::test {

/// A rank that takes no messages while this lives.
class Hang {
 public:
  Hang(TestServer& server, int rank) : transport_(server.serverRank(rank).transport) {
    transport_.onMessage(Channel::Test, [this](int, Bytes) {
      begun_.count_down();
      over_.wait();
    });
    server.serverRank(0).transport.send(rank, Channel::Test, {});
    begun_.wait();
  }
  ~Hang() {
    over_.count_down();
    transport_.onMessage(Channel::Test, nullptr);
  }

 private:
  Transport& transport_;
  std::latch begun_{1}, over_{1};
};

}  // namespace gxy::test
