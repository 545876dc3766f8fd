// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <nlohmann/json.hpp>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {

// A point of time `seconds` later, which may be infinitely many.
Interrupt::Clock::time_point later(Interrupt::Clock::time_point begin,
                                   std::chrono::duration<double> seconds) {
  constexpr std::chrono::hours kForEver(24 * 365 * 100);
  return begin +
         (seconds < kForEver ? std::chrono::duration_cast<Interrupt::Clock::duration>(seconds) : kForEver);
}

std::set<std::string> namesIn(const std::string& steerable) {
  std::set<std::string> names;
  for (const auto& one : nlohmann::json::parse(steerable)) names.insert(one.at("name").get<std::string>());
  return names;
}

}  // namespace

Simulation::Simulation(Options options, Member member)
    : every_(options.every),
      firstTime_(options.firstTime),
      lastTime_(options.lastTime),
      patience_(options.patience),
      steerable_(namesIn(options.steerable)),
      connection_(options.on ? std::make_unique<Connection>(std::move(options), std::move(member))
                             : nullptr) {}

// Whether a publish, counted from 1, is offered at all. It is the same on all ranks, so they count the same publishes.
bool Simulation::passes(int64_t number, double time) const {
  return (number - 1) % every_ == 0 && !(time < firstTime_) && !(time > lastTime_);
}

void Simulation::await(Clock::time_point begun) {
  if (patience_.count() > 0) connection_->await(later(begun, patience_), Connection::Loss::EndsTheWait);
}

void Simulation::checkOrder(int64_t step, const char* function) const {
  if (last_) throw Error(std::string(function) + " after gxy_publish_last, expected nothing but gxy_close");
  if (statistics_.offered > 0 && step <= lastStep_)
    throw Error(std::string(function) + ": step " + std::to_string(step) + " after step " +
                std::to_string(lastStep_) + ", expected steps that ascend");
}

// What every publish begins with. Throws Error where it is used wrongly.
void Simulation::begin(int64_t step, const char* function) {
  checkOrder(step, function);
  meshes_.check(function);
}

// Before a publish that counts: what is described is true from that one on.
void Simulation::describe() {
  if (meshes_.hasNews()) connection_->describe(meshes_.describe());
}

Meshes& Simulation::meshes(const char* function) {
  if (last_) throw Error(std::string(function) + " after gxy_publish_last, expected nothing but gxy_close");
  return meshes_;
}

void Simulation::grid(const std::string& mesh, int block, int of, const Grid& grid, const Extent& owned) {
  // Where ranks wait, no step may be left out. So a rank whose grid stays takes none either by a plan that other ranks have left.
  const Meshes::News news = patience_.count() > 0 ? Meshes::News::Each : Meshes::News::Changes;
  meshes("gxy_grid").grid(mesh, block, of, grid, owned, asked_ ? Meshes::News::None : news);
}

void Simulation::count(int64_t step) {
  lastStep_ = step;
  statistics_.offered++;
}

int Simulation::missed() const { return connection_->connected() ? GXY_NOT_TAKEN : GXY_LOST; }

int Simulation::wanted(int64_t step, double time) {
  if (!connection_) return 0;
  begin(step, "gxy_wanted");
  if (passes(statistics_.offered + 1, time)) describe();
  if (asked_)
    throw Error("gxy_wanted: it has been asked for this publish already, expected gxy_publish next");
  bool isNext = false;
  if (passes(statistics_.offered + 1, time)) {
    await(Clock::now());
    isNext = connection_->isNext();
  }
  asked_ = {{step, time}, isNext};
  return isNext ? 1 : 0;
}

void Simulation::settle(int64_t step, bool any) {
  if (!connection_) return;
  if (!asked_ || asked_->step.step != step)
    throw Error("gxy_wanted_settle: step " + std::to_string(step) +
                ", expected that of gxy_wanted just before");
  asked_->take = any;
}

int Simulation::publish(int64_t step, double time) {
  const auto begun = Clock::now();
  if (!connection_) return GXY_OFF;
  begin(step, "gxy_publish");
  const bool isSame =
      !asked_ || (asked_->step.step == step && (asked_->step.time == time || std::isnan(time)));
  if (!isSame)
    throw Error("gxy_publish: step " + std::to_string(step) + " after gxy_wanted for step " +
                std::to_string(asked_->step.step) + ", expected the same step and time");
  if (passes(statistics_.offered + 1, time)) describe();
  const bool declined = asked_ && !asked_->take, waited = asked_.has_value();
  asked_.reset();
  count(step);
  int result = missed();
  if (passes(statistics_.offered, time)) {
    if (!waited) await(begun);
    const bool isDue = connection_->publish();
    if (isDue && declined)
      connection_->notFilled(connection_->route() != nullptr);
    else
      result = isDue ? take({step, time}) : missed();
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  statistics_.publish_seconds += seconds;
  statistics_.longest_seconds = std::max(statistics_.longest_seconds, seconds);
  return result;
}

int Simulation::skip(int64_t step, double time) {
  if (!connection_) return GXY_OFF;
  checkOrder(step, "gxy_skip");
  asked_.reset();
  const bool counts = passes(statistics_.offered + 1, time);
  if (counts && meshes_.isDescribed() && meshes_.hasNews())  // The other ranks may publish it.
    connection_->describe(meshes_.describeBlocks());
  count(step);
  if (counts && connection_->publish()) connection_->notFilled(true);
  return missed();
}

bool Simulation::steered(const std::string& parameter, double& value) {
  if (steerable_.count(parameter) == 0)
    throw Error("gxy_steered: \"" + parameter + "\", expected one of the option \"steerable\"");
  const auto now = steering_.find(parameter);
  if (now == steering_.end()) return false;
  const auto before = seen_.find(parameter);
  if (before != seen_.end() && before->second == now->second) return false;
  seen_[parameter] = value = now->second;
  return true;
}

int Simulation::publishLast(int64_t step, double time) {
  if (!connection_) return GXY_OFF;
  begin(step, "gxy_publish_last");
  if (!meshes_.isDescribed()) describe();
  meshes_.checkNews();  // before anything is changed
  meshes_.keep();
  describe();
  count(step);
  last_ = {step, time};
  return connection_->lost() ? GXY_LOST : GXY_TAKEN;
}

int Simulation::take(const Step& step) {
  const auto route = connection_->route();
  uint64_t bytes = 0;
  const Counts counts = meshes_.counts();
  if (!route) {  // The server does not know yet that this rank has something else now.
    connection_->notFilled(false);
    return GXY_NOT_TAKEN;
  }
  try {
    bytes = meshes_.bytes(route->destinations, route->encodings, counts);
    meshes_.copy(route->destinations, route->encodings, counts, route->slot->reserve(bytes));
  } catch (const std::bad_alloc&) {
    connection_->notFilled(false);
    return GXY_NOT_TAKEN;
  } catch (const std::exception&) {
    connection_->notFilled(false);
    throw;
  }
  steering_ = connection_->steering();
  connection_->filled(step.step, step.time, counts);
  statistics_.taken++;
  statistics_.bytes += int64_t(bytes);
  return GXY_TAKEN;
}

// Waits until the last step is published, or `until` has come. A step that the server has given up is offered again.
void Simulation::deliverLast(Clock::time_point until) {
  while (connection_->await(until, Connection::Loss::IsWaitedOut)) {
    if (!connection_->publishLast()) continue;  // The server has changed its mind meanwhile.
    const uint64_t before = connection_->published();
    take(*last_);
    connection_->settle(until);
    if (connection_->published() > before) return;
  }
}

gxy_stat Simulation::statistics() const {
  gxy_stat s = statistics_;
  if (connection_) s.published = int64_t(connection_->published());
  return s;
}

void Simulation::close(double seconds) {
  if (!connection_) return;
  const auto until = later(Clock::now(), std::chrono::duration<double>(seconds));
  if (last_) deliverLast(until);
  connection_->settle(until);
  connection_->close();
}

}  // namespace gxy::insitu
