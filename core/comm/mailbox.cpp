// SPDX-License-Identifier: Apache-2.0
#include "core/comm/mailbox.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

#include "core/comm/error_text.h"
#include "core/comm/presence.h"

namespace gxy {

void logError(int rank, const std::string& message) { spdlog::error("rank {}: {}", rank, message); }

void guarded(const ErrorReport& report, int rank, const char* what, const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    report(rank, std::string(what) + " failed: " + textOf(error));
  } catch (...) {
    report(rank, std::string(what) + " failed with an exception that is no std::exception");
  }
}

namespace {

constexpr std::string_view kMessage = "message: ";

/// The name of its messages in a trace.
std::string_view stageOf(Channel channel) {
  if (channel == kPresenceChannel) return "message: presence";
  switch (channel) {
    case Channel::Work:
      return "message: work";
    case Channel::Completion:
      return "message: completion";
    case Channel::Collective:
      return "message: collective";
    case Channel::Rays:
      return "message: rays";
    case Channel::Contributions:
      return "message: pixels";
    case Channel::Frame:
      return "message: frame";
    case Channel::Credits:
      return "message: credits";
    case Channel::Items:
      return "message: items";
    case Channel::Flight:
      return "message: flight";
    case Channel::ItemCredits:
      return "message: credits of items";
    case Channel::ItemCompletion:
      return "message: completion of items";
    case Channel::SampleFlight:
      return "message: flight of samplings";
    case Channel::SampleRays:
      return "message: sampling rays";
    case Channel::SampleCredits:
      return "message: credits of samplings";
    case Channel::SampleCompletion:
      return "message: completion of samplings";
    case Channel::Pictures:
      return "message: pictures";
    case Channel::Test:
      break;
  }
  return "message: others";
}

}  // namespace

std::string_view nameOf(Channel channel) { return stageOf(channel).substr(kMessage.size()); }

bool Mailbox::deliver(Delivery delivery) {
  std::lock_guard lock(running_);
  const auto found = handlers_.find(delivery.channel);
  if (found == handlers_.end()) {
    const Channel channel = delivery.channel;
    kept_[channel].push_back(std::move(delivery));
    return false;
  }
  const Trace::Span span(trace_, stageOf(delivery.channel), delivery.message.size());
  const auto handler = found->second;  // a copy: the handler may replace itself
  (*handler)(delivery.source, std::move(delivery.message));
  return true;
}

std::vector<Delivery> Mailbox::setHandler(Channel channel, Transport::Handler handler) {
  std::lock_guard lock(running_);
  if (!handler) {
    handlers_.erase(channel);
    return {};
  }
  handlers_[channel] = std::make_shared<const Transport::Handler>(std::move(handler));
  const auto kept = kept_.extract(channel);
  return kept ? std::move(kept.mapped()) : std::vector<Delivery>{};
}

}  // namespace gxy
