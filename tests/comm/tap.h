// SPDX-License-Identifier: Apache-2.0
// A Transport that shows what is sent.
#pragma once
#include <functional>
#include <utility>

#include "core/comm/transport.h"

namespace gxy::test {

/// Passes everything on. `look` sees each message that is sent, and may change it.
class Tap final : public Transport {
 public:
  using Look = std::function<void(int destination, Channel, Bytes&)>;
  Tap(Transport& to, Look look) : to_(to), look_(std::move(look)) {}
  int rank() const override { return to_.rank(); }
  int size() const override { return to_.size(); }
  void send(int destination, Channel channel, Bytes message) override {
    look_(destination, channel, message);
    to_.send(destination, channel, std::move(message));
  }
  void onMessage(Channel channel, Handler handler) override { to_.onMessage(channel, std::move(handler)); }
  void post(Task task) override { to_.post(std::move(task)); }
  void postWaiting(Task task) override { to_.postWaiting(std::move(task)); }
  Counters counters() const override { return to_.counters(); }

 private:
  Transport& to_;
  const Look look_;
};

}  // namespace gxy::test
