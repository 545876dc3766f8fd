// SPDX-License-Identifier: Apache-2.0
// What both transports share: the table of handlers of a rank, and what becomes of an exception that nobody
// catches.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/comm/trace.h"
#include "core/comm/transport.h"

namespace gxy {

/// Told of every exception that leaves a handler or a task: the rank, and what was running and why it failed.
using ErrorReport = std::function<void(int rank, const std::string& message)>;

/// The report that is made when none is given: an spdlog error with the rank.
void logError(int rank, const std::string& message);

/// Runs `action`; an exception is reported, not passed on.
void guarded(const ErrorReport& report, int rank, const char* what, const std::function<void()>& action);

/// A message on its way to a handler.
struct Delivery {
  int source;
  Channel channel;
  Bytes message;
};

/// The handlers of one rank, run one at a time.
class Mailbox {
 public:
  /// Messages handled are stages of `trace`, if not null.
  explicit Mailbox(Trace* trace = nullptr) : trace_(trace) {}

  /// Runs the handler of the message's channel. Without one the message is kept, and false returned.
  bool deliver(Delivery delivery);

  /// Sets or, with an empty one, removes a handler, after a running handler has ended (unless this is a call
  /// from inside it). Returns the messages that were kept for it, to be delivered again.
  std::vector<Delivery> setHandler(Channel channel, Transport::Handler handler);

 private:
  Trace* const trace_;
  std::recursive_mutex running_;  ///< held while a handler runs; recursive, as a handler may set handlers
  std::map<Channel, std::shared_ptr<const Transport::Handler>> handlers_;
  std::map<Channel, std::vector<Delivery>> kept_;
};

}  // namespace gxy
