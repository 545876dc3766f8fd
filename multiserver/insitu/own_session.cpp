// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/own_session.h"

#include <string_view>
#include <utility>

#include "multiserver/server/modules.h"

namespace gxy {

using protocol::MessageChannel;

OwnSession::OwnSession(ServerRank& serverRank, const std::string& tenant, const std::string& client)
    : serverRank_(serverRank) {
  const auto wake = [&transport = serverRank.transport, replies = replies_] {
    transport.post([replies] { replies->take(); });
  };
  outbox_ = std::make_shared<Outbox>(Outbox::Limits{}, wake, serverRank.ledger.enter(tenant, "clients", 0));
  replies_->outbox = outbox_;
  session_ = std::make_shared<Session>(serverRank, outbox_, Session::Identity{0, client, tenant, false},
                                       protocol::Limits{});
}

void OwnSession::end() {
  session_->end();
  outbox_->close();
  std::unique_lock lock(replies_->mutex);
  replies_->over = true;
  replies_->waiting.clear();
  replies_->ended.wait(lock, [this] { return replies_->running == 0; });
}

void OwnSession::Replies::take() {
  const auto from = outbox.lock();
  if (!from) return;
  while (const auto message = from->next()) {
    if (message->channel != MessageChannel::Reply) continue;
    std::function<void(const std::string&)> done;
    {
      const std::lock_guard lock(mutex);
      const auto at = waiting.find(message->id);
      if (at == waiting.end()) continue;
      done = std::move(at->second);
      waiting.erase(at);
      running++;
    }
    constexpr std::string_view kError = "error: ";
    const std::string_view text = message->text();
    const std::shared_ptr<void> over(nullptr, [this](void*) {
      const std::lock_guard lock(mutex);
      running--;
      ended.notify_all();
    });
    done(text.starts_with(kError) ? std::string(text.substr(kError.size())) : std::string());
  }
}

void OwnSession::load(const std::string& module) { session_->addModule(serverRank_.modules->load(module)); }

void OwnSession::run(const std::string& statement, std::function<void(const std::string&)> done) {
  uint32_t id = 0;
  {
    const std::lock_guard lock(replies_->mutex);
    if (replies_->over) return;
    id = ++last_;
    replies_->waiting[id] = std::move(done);
  }
  const auto* bytes = reinterpret_cast<const std::byte*>(statement.data());
  session_->submit(id, Bytes(bytes, bytes + statement.size()));
}

}  // namespace gxy
