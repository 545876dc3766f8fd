// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/exchanges.h"

#include <algorithm>
#include <utility>

#include "core/comm/error.h"
#include "multiserver/server/server_rank.h"
#include "multiserver/server/session.h"

namespace gxy {

Asker askerOf(Request& request) {
  return {[&request] { request.check(); },
          [&request](int64_t done, int64_t of, const std::string& text, bool phase) {
            request.progress(done, of, text, phase);
          }};
}

void Exchanges::addWorks() {
  serverRank_.work.add("exchanges.cancel", [this](const Work::Call& call) -> nlohmann::json {
    const std::lock_guard lock(mutex_);
    const auto part = underWay_.find(call.parameters.at("exchange").get<uint64_t>());
    if (part != underWay_.end()) part->second = true;
    return nullptr;
  });
}

std::shared_ptr<const uint64_t> Exchanges::begin(Request& request) { return begin(request, nullptr); }

std::shared_ptr<const uint64_t> Exchanges::beginLong(Request& request) {
  return begin(request, serverRank_.tenants.beginLong(request.session().tenant(), [&] { request.check(); }));
}

std::shared_ptr<const uint64_t> Exchanges::beginLong(const std::string& tenant, Asker asker) {
  auto turn = serverRank_.tenants.beginLong(tenant, asker.check);
  return begin(std::move(asker), std::move(turn));
}

std::shared_ptr<const uint64_t> Exchanges::begin(Asker asker) { return begin(std::move(asker), nullptr); }

std::shared_ptr<const uint64_t> Exchanges::begin(Request& request, std::shared_ptr<void> turn) {
  auto begun = begin(askerOf(request), std::move(turn));
  request.onCancel([this, number = *begun] { cancel(number); });
  return begun;
}

std::shared_ptr<const uint64_t> Exchanges::begin(Asker asker, std::shared_ptr<void> turn) {
  const uint64_t number = serverRank_.nextExchange();
  {
    const std::lock_guard lock(mutex_);
    led_.emplace(number, std::move(asker));
  }
  return {new uint64_t(number), [this, turn = std::move(turn)](const uint64_t* led) {
            const std::lock_guard lock(mutex_);
            led_.erase(*led);
            delete led;
          }};
}

void Exchanges::cancel(uint64_t number) {
  serverRank_.work.broadcast("exchanges.cancel", {{"exchange", number}}, [](std::vector<Work::Reply>) {});
}

void Exchanges::alsoCheck(uint64_t number, std::function<void()> check) {
  const std::lock_guard lock(mutex_);
  auto& checks = led_.at(number).check;
  checks = [first = std::move(check), then = std::move(checks)] {
    first();
    then();
  };
}

// Rank 0 also asks the asker, because the message "exchanges.cancel" may come before the part has begun.
void Exchanges::check(uint64_t number) const {
  const std::lock_guard lock(mutex_);
  if (underWay_.at(number)) throw Error("cancelled");
  if (const auto led = led_.find(number); led != led_.end()) led->second.check();
}

Exchanges::Part::Part(Exchanges& exchanges, uint64_t number)
    : ranks(exchanges.serverRank_.collectives(
          number, [this] { exchanges_.check(number_); }, [this](double fraction) { tell(fraction, false); })),
      exchanges_(exchanges),
      number_(number) {
  const std::lock_guard lock(exchanges_.mutex_);
  exchanges_.underWay_.emplace(number, false);
}

Exchanges::Part::~Part() {
  exchanges_.serverRank_.collective.finish(number_);
  const std::lock_guard lock(exchanges_.mutex_);
  exchanges_.underWay_.erase(number_);
}

void Exchanges::Part::begin(int64_t item, int64_t of, const std::string& text, bool phase) {
  item_ = item;
  of_ = of;
  text_ = text;
  agree(ranks, [&] {
    ranks.check();
    tell(0, phase);
  });
}

void Exchanges::Part::tell(double fraction, bool phase) {
  const std::lock_guard lock(exchanges_.mutex_);
  const auto led = exchanges_.led_.find(number_);
  if (led == exchanges_.led_.end()) return;
  // 100 % is reported only by the request itself, when all ranks are done and all data have names.
  const auto done = std::min(kUnits * item_ + int64_t(fraction * kUnits), kUnits * of_ - 1);
  led->second.progress(done, kUnits * of_, text_, phase);
}

}  // namespace gxy
