// SPDX-License-Identifier: Apache-2.0
// Shows the replies and events that a server sends, and writes its pictures to files.
#pragma once
#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "multiserver/client/client.h"
#include "tools/msdata/output.h"

namespace gxy {

/// Shows replies and events as text or as lines of JSON, and writes pictures to the current folder. Thread safe.
class Report {
 public:
  Report(Output& output, bool json) : output_(output), json_(json) {}

  /// Sets a client's callbacks to this report, which must outlive the client.
  void listenTo(Client::Options& options);
  void reply(const std::string& statement, const Reply& reply);
  /// Waits for the end of the connection and returns the reason. May be called once.
  std::string waitForEnd() { return ended_.get_future().get(); }

  /// Whether a statement has failed or a picture could not be written.
  bool failed() const { return failed_; }

 private:
  void event(const nlohmann::json& event);
  void picture(const nlohmann::json& header, std::span<const std::byte> content);
  /// Tells of a part of an array of `fetch`; `export` is for who wants files.
  void array(const nlohmann::json& header, std::span<const std::byte> content);

  Output& output_;
  const bool json_;
  std::atomic<bool> failed_ = false;
  std::promise<std::string> ended_;
};

/// Returns an event as one line of text for users.
std::string eventText(const nlohmann::json& event);

}  // namespace gxy
