// SPDX-License-Identifier: Apache-2.0
#include "gxy/server/tenants.h"

#include <sys/random.h>

#include <array>
#include <chrono>

#include "gxy/comm/error.h"

namespace gxy {

std::string newToken() {
  std::array<unsigned char, 32> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
    throw Error("token: the system gives no random bytes");
  std::string token;
  for (const unsigned char b : bytes) {
    token += "0123456789abcdef"[b >> 4];
    token += "0123456789abcdef"[b & 15];
  }
  return token;
}

bool sameToken(const std::string& given, const std::string& expected) {
  unsigned difference = given.size() == expected.size() ? 0 : 1;
  for (size_t i = 0; i < given.size(); i++)
    difference |= unsigned(given[i]) ^ unsigned(expected.empty() ? '\0' : expected[i % expected.size()]);
  return difference == 0;
}

void Tenants::add(const std::string& token, Identity identity) { identities_[token] = std::move(identity); }

std::optional<Tenants::Identity> Tenants::identify(const std::string& token,
                                                   const std::string& tenant) const {
  if (admitsAll_) return Identity{tenant, true};
  std::optional<Identity> found;
  for (const auto& [expected, identity] : identities_)  // all of them, whichever it is
    if (sameToken(token, expected)) found = identity;
  return found;
}

Tenants::Account& Tenants::account(const std::string& tenant) {
  const auto [at, made] = state_->accounts.try_emplace(tenant);
  if (made) at->second.number = uint32_t(state_->accounts.size());
  return at->second;
}

Tenants::Frame Tenants::entered(const std::string& tenant) {
  account(tenant).frames++;
  Frame frame;
  frame.end_ = [state = state_, tenant, begin = std::chrono::steady_clock::now()] {
    const std::lock_guard lock(state->mutex);
    Account& account = state->accounts.at(tenant);
    account.frames--;
    account.done++;
    account.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    state->ended.notify_all();
  };
  return frame;
}

Tenants::Frame Tenants::begin(const std::string& tenant) {
  const std::lock_guard lock(state_->mutex);
  if (account(tenant).frames >= frames_)
    throw Error("tenant " + tenant + ": " + std::to_string(frames_) +
                " renderings are in flight, expected fewer; wait for one to end");
  return entered(tenant);
}

Tenants::Frame Tenants::beginWhenFree(const std::string& tenant, const std::function<void()>& check) {
  std::unique_lock lock(state_->mutex);
  while (account(tenant).frames >= frames_) {
    lock.unlock();
    check();
    lock.lock();
    state_->ended.wait_for(lock, std::chrono::milliseconds(100));
  }
  return entered(tenant);
}

nlohmann::json Tenants::statistics() const {
  const std::lock_guard lock(state_->mutex);
  auto list = nlohmann::json::array();
  for (const auto& [name, account] : state_->accounts)
    list.push_back({{"tenant", name},
                    {"frames in flight", account.frames},
                    {"frames", account.done},
                    {"frame seconds", account.seconds}});
  return list;
}

uint32_t Tenants::number(const std::string& tenant) {
  const std::lock_guard lock(state_->mutex);
  return account(tenant).number;
}

}  // namespace gxy
