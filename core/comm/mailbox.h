// SPDX-License-Identifier: Apache-2.0
// Parts that both transports share: the table of a rank's message handlers, and the reporting of exceptions
// that leave a handler or task.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/comm/trace.h"
#include "core/comm/transport.h"

namespace gxy {

/// Called for every exception that leaves a handler or a task. `message` says what was running and why it failed.
using ErrorReport = std::function<void(int rank, const std::string& message)>;

/// The default report: logs an error with the rank (spdlog).
void logError(int rank, const std::string& message);

/// Runs `action`. An exception is reported and not passed on. `what` names the action in the report ("a task").
void guarded(const ErrorReport& report, int rank, const char* what, const std::function<void()>& action);

/// Returns what the messages of a channel are called, such as "rays".
std::string_view nameOf(Channel channel);

/// A message on its way to a handler.
struct Delivery {
  int source;
  Channel channel;
  Bytes message;
};

/// The handlers of one rank, run one at a time.
class Mailbox {
 public:
  /// Each handled message becomes a stage of `trace`, unless it is null. `trace` must outlive the mailbox.
  explicit Mailbox(Trace* trace = nullptr) : trace_(trace) {}

  /// Runs the handler of the message's channel. If there is none, keeps the message and returns false.
  bool deliver(Delivery delivery);

  /// Sets a handler; an empty one removes the present handler. Waits for a running handler to end, unless
  /// the call comes from inside it. Returns the messages that were kept for the channel: the caller
  /// delivers them again.
  std::vector<Delivery> setHandler(Channel channel, Transport::Handler handler);

 private:
  Trace* const trace_;
  std::recursive_mutex running_;  ///< held while a handler runs; recursive because a handler may set handlers
  std::map<Channel, std::shared_ptr<const Transport::Handler>> handlers_;
  std::map<Channel, std::vector<Delivery>> kept_;
};

}  // namespace gxy
