// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/tenants.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {

std::array<unsigned char, 32> randomBytes() {
  std::array<unsigned char, 32> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
    throw Error("token: the system gives no random bytes");
  return bytes;
}

std::string newToken() {
  std::string token;
  for (const unsigned char b : randomBytes()) {
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

std::string Tenants::wrongName(const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name[0] == '.')
    return "expected a name without / that does not begin with a dot, found " + inQuotes(name);
  if (name == "server" || name == "device")
    return "expected another name than " + name + ", under which memory of no tenant is counted";
  return {};
}

void Tenants::add(const std::string& token, Identity identity) { identities_[token] = std::move(identity); }

std::string Tenants::tokenOf(const Identity& identity) const {
  for (const auto& [token, known] : identities_)
    if (known == identity) return token;
  return {};
}

std::optional<Tenants::Identity> Tenants::identify(const std::string& token,
                                                   const std::string& tenant) const {
  if (admitsAll_) {
    if (const std::string wrong = wrongName(tenant); !wrong.empty()) throw Error("hello: `tenant`: " + wrong);
    return Identity{tenant, true, false};
  }
  std::optional<Identity> found;
  for (const auto& [expected, identity] : identities_)  // compare all, in constant time
    if (sameToken(token, expected)) found = identity;
  return found;
}

Tenants::Account& Tenants::account(const std::string& tenant) {
  const auto [at, made] = state_->accounts.try_emplace(tenant);
  if (made) at->second.number = uint32_t(state_->accounts.size());
  return at->second;
}

Tenants::RenderSlot Tenants::entered(const std::string& tenant, int64_t bytes) {
  account(tenant).frames++;
  account(tenant).bytes += bytes;
  RenderSlot frame;
  frame.end_ = [state = state_, tenant, bytes, begin = std::chrono::steady_clock::now()] {
    const std::lock_guard lock(state->mutex);
    Account& account = state->accounts.at(tenant);
    account.frames--;
    account.bytes -= bytes;
    account.done++;
    account.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    state->ended.notify_all();
  };
  return frame;
}

namespace {

[[noreturn]] void failNoRoom(const std::string& tenant, int64_t bytes, int64_t room) {
  throw Error("memory: the picture takes " + std::to_string(bytes) + " bytes, but of tenant " + tenant +
              "'s " + std::to_string(std::max(room, int64_t(0))) + " are free, expected room for it");
}

}  // namespace

Tenants::RenderSlot Tenants::begin(const std::string& tenant, const Cost& cost) {
  const std::lock_guard lock(state_->mutex);
  if (account(tenant).frames >= frames_)
    throw Error("tenant " + tenant + ": " + std::to_string(frames_) +
                " renderings are in flight, expected fewer; wait for one to end");
  const int64_t room = cost.room() - account(tenant).bytes;
  if (cost.bytes > room) failNoRoom(tenant, cost.bytes, room);
  return entered(tenant, cost.bytes);
}

Tenants::RenderSlot Tenants::beginWhenFree(const std::string& tenant, const Cost& cost,
                                           const std::function<void()>& check) {
  std::unique_lock lock(state_->mutex);
  for (;;) {
    const Account& now = account(tenant);
    const int64_t room = cost.room() - now.bytes;
    if (now.frames < frames_ && cost.bytes <= room) return entered(tenant, cost.bytes);
    if (now.frames == 0) failNoRoom(tenant, cost.bytes, room);
    lock.unlock();
    check();
    lock.lock();
    state_->ended.wait_for(lock, std::chrono::milliseconds(100));
  }
}

std::shared_ptr<void> Tenants::beginAside(const std::string& tenant) {
  const std::lock_guard lock(state_->mutex);
  if (account(tenant).aside >= kAside)
    throw Error("tenant " + tenant + ": " + std::to_string(kAside) +
                " long requests run, expected fewer; wait for one to end");
  account(tenant).aside++;
  return {nullptr, [state = state_, tenant](void*) {
            const std::lock_guard lock(state->mutex);
            state->accounts.at(tenant).aside--;
          }};
}

std::shared_ptr<void> Tenants::beginLong(const std::string& tenant, const std::function<void()>& check) {
  std::unique_lock lock(state_->mutex);
  while (account(tenant).longWorks >= kLong) {
    lock.unlock();
    check();
    lock.lock();
    state_->ended.wait_for(lock, std::chrono::milliseconds(100),
                           [&] { return account(tenant).longWorks < kLong; });
  }
  account(tenant).longWorks++;
  return {nullptr, [state = state_, tenant](void*) {
            const std::lock_guard lock(state->mutex);
            state->accounts.at(tenant).longWorks--;
            state->ended.notify_all();
          }};
}

nlohmann::json Tenants::statistics() const {
  const std::lock_guard lock(state_->mutex);
  auto list = nlohmann::json::array();
  for (const auto& [name, account] : state_->accounts)
    list.push_back({{"tenant", name},
                    {"frames in flight", account.frames},
                    {"picture bytes", account.bytes},
                    {"frames", account.done},
                    {"frame seconds", account.seconds}});
  return list;
}

uint32_t Tenants::number(const std::string& tenant) {
  const std::lock_guard lock(state_->mutex);
  return account(tenant).number;
}

std::string Tenants::name(uint32_t number) const {
  const std::lock_guard lock(state_->mutex);
  for (const auto& [name, account] : state_->accounts)
    if (account.number == number) return name;
  return {};
}

}  // namespace gxy
