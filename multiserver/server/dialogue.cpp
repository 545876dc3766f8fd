// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/dialogue.h"

#include <algorithm>

#include "core/comm/error.h"

namespace gxy {

using protocol::MessageChannel;
using protocol::MessageReader;

namespace {

MessageReader::Rules helloRules() {
  MessageReader::Rules rules;
  rules.most[size_t(MessageChannel::Control)] = protocol::kMaxHelloBytes;
  return rules;
}

}  // namespace

Dialogue::Dialogue(std::shared_ptr<Outbox> outbox, protocol::Limits limits, Admit admit)
    : outbox_(std::move(outbox)), limits_(limits), admit_(std::move(admit)), reader_(helloRules()) {}

bool Dialogue::paused() const { return outbox_->aboveWatermark() || (session_ && session_->full()); }

void Dialogue::take(std::span<const std::byte>& bytes) {
  takePreamble(bytes);
  while (!bytes.empty() && !over_ && !paused()) {
    auto message = reader_.take(bytes);
    if (!message) continue;
    if (message->channel == MessageChannel::Control)
      control(message->text());
    else if (message->skipped)
      session_->refuse(message->id);
    else
      session_->submit(message->id, std::move(message->payload));
  }
}

void Dialogue::takePreamble(std::span<const std::byte>& bytes) {
  const size_t size = std::min(bytes.size(), preamble_.size() - preambleBytes_);
  if (size == 0) return;
  std::copy_n(bytes.begin(), size, preamble_.begin() + std::ptrdiff_t(preambleBytes_));
  preambleBytes_ += size;
  bytes = bytes.subspan(size);
  if (preambleBytes_ < preamble_.size()) return;
  over_ = isStrange_ = !std::equal(protocol::kMagic.begin(), protocol::kMagic.end(),
                                   reinterpret_cast<const unsigned char*>(preamble_.data()));
  if (!over_) protocol::checkPreamble(preamble_);
}

void Dialogue::control(std::string_view text) {
  if (!session_) return hello(text);
  if (const auto number = protocol::afterWord(text, "ping")) {
    if (number->size() > 20 ||
        !std::all_of(number->begin(), number->end(), [](char c) { return c >= '0' && c <= '9'; }))
      throw Error("ping: expected `ping N`, N of at most 20 digits");
    return outbox_->control("pong " + std::string(*number));
  }
  if (protocol::afterWord(text, "pong")) return;
  if (!protocol::afterWord(text, "bye")) throw Error("control message: expected ping, pong or bye");
  over_ = true;
}

void Dialogue::hello(std::string_view text) {
  protocol::Welcome welcome;
  session_ = admit_(protocol::parseHello(text), outbox_, welcome);
  MessageReader::Rules rules = MessageReader::fromClient(limits_.requestBytes);
  rules.room = [session = session_.get()](uint64_t bytes) { return session->makeRoom(bytes); };
  reader_.setRules(std::move(rules));
  outbox_->control(protocol::welcomeText(welcome));
}

}  // namespace gxy
