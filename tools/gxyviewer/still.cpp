// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/still.h"

#include "core/scene/state_file.h"
#include "multiserver/protocol/json.h"

namespace gxy {

using nlohmann::json;
using protocol::PixelKind;

std::shared_ptr<Still> Still::begin(Client& client, uint32_t window, const State& state, uint32_t passes) {
  const glm::ivec2 size = state.cameras.at(0).dimensions;
  const std::shared_ptr<Still> still(new Still(size));
  const auto ask = [&](const char* verb, const std::string& argument) {
    client.send(std::string(verb) + " " + std::to_string(window) + " " + argument,
                [still](const Reply& reply) {
                  if (!reply.ok) still->end(reply.error);
                });
  };
  ask("viewer.window", protocol::dump({{"size", {size.x, size.y}}}));
  ask("viewer.set", writeState(state));
  ask("viewer.render", protocol::dump({{"levels", {1}}, {"rays", 1}, {"passes", passes}}));
  return still;
}

void Still::end(const std::string& error) {
  const std::lock_guard lock(mutex_);
  if (progress_.error.empty()) progress_.error = error;
  progress_.ended = true;
}

void Still::take(const protocol::PixelHeader& header, std::span<const std::byte> data) {
  const std::lock_guard lock(mutex_);
  if (progress_.ended) return;
  if (header.kind != PixelKind::EndOfFrame) {
    canvas_.take(header, data);
    if (header.kind == PixelKind::EndOfPass) progress_.passes = header.pass + 1;
    return;
  }
  const json end = protocol::parseObject({reinterpret_cast<const char*>(data.data()), data.size()}, "frame");
  const std::string status = end.at("status");
  progress_.generations = end.at("generations").get<std::map<std::string, uint64_t>>();
  progress_.ended = true;
  if (status != "complete") progress_.error = "the frame was " + status + ": " + end.value("error", "");
}

Still::Progress Still::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

}  // namespace gxy
