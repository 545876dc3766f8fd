// SPDX-License-Identifier: Apache-2.0
// What becomes of that which a server sends: replies, events, pictures.
#pragma once
#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "multiserver/client/client.h"
#include "tools/msdata/output.h"

namespace gxy {

/// Shows it, as text for people or as lines of JSON, and writes pictures to the current folder. Thread safe.
class Report {
 public:
  Report(Output& output, bool json) : output_(output), json_(json) {}

  /// Has a client's callbacks come here. The report outlives the client.
  void listenTo(Client::Options& options);
  void reply(const std::string& statement, const Reply& reply);
  /// Waits for the end of the connection; why it came.
  std::string waitForEnd() { return ended_.get_future().get(); }

  /// A statement has failed, or a picture could not be written.
  bool failed() const { return failed_; }

 private:
  void event(const nlohmann::json& event);
  void picture(const nlohmann::json& header, std::span<const std::byte> content);

  Output& output_;
  const bool json_;
  std::atomic<bool> failed_ = false;
  std::promise<std::string> ended_;
};

/// An event on one line, for people.
std::string eventText(const nlohmann::json& event);

}  // namespace gxy
