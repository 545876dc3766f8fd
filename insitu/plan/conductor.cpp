// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/conductor.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {
constexpr int kSuccesses = 16;                       // in a row, after which the margin is halved
constexpr uint64_t kMostMargin = uint64_t(1) << 40;  // and the largest count

uint64_t bitsOf(double time) {
  return std::bit_cast<uint64_t>(time);
}  // NaN, for an unknown time, equals NaN
}  // namespace

Conductor::Conductor(int ranks)
    : said_(size_t(ranks)), known_(size_t(ranks)), answered_(size_t(ranks)), taken_(size_t(ranks)) {}

void Conductor::describe(int rank, uint64_t from) {
  uint64_t& said = said_.at(size_t(rank));
  uint64_t& known = known_[size_t(rank)];
  if (from > kMostMargin || from <= said || (said > 0 && from <= known))
    throw Error("a description from publish " + std::to_string(from) +
                " on, expected one of publishes after " + std::to_string(std::max(said, known)));
  said = from;
  known = std::max(known, from);
  described_ = std::max(described_, from);
}

bool Conductor::canPlan() const {
  const auto isZero = [](uint64_t from) { return from == 0; };
  const auto isFarEnough = [this](uint64_t count) { return count >= described_; };
  return std::none_of(said_.begin(), said_.end(), isZero) &&
         std::all_of(known_.begin(), known_.end(), isFarEnough);
}

void Conductor::plan(uint64_t from, std::set<int> owners) {
  if (state_ != State::Idle && state_ != State::Looking) throw Error("a step is under way, expected none");
  planned_ = from;
  owners_ = std::move(owners);
}

bool Conductor::isHeldUp() const {
  // Ranks that wait come to the step first. The others miss it.
  return needsPlan() && state_ == State::Collecting && described_ <= step_.count &&
         (canPlan() || !ranksWait_);
}

Control Conductor::ask() {
  state_ = State::Asking;
  answered_.assign(answered_.size(), false);
  answers_ = 0;
  answer_ = 0;
  return {Control::Kind::AskNewest, ++question_, 0};
}

std::vector<Control> Conductor::look() {
  if (state_ != State::Idle) return {};  // Some have not answered yet.
  const Control question = ask();
  state_ = State::Looking;
  return {question};
}

std::vector<Control> Conductor::begin(uint64_t from) {
  if (state_ != State::Idle && state_ != State::Looking) throw Error("a step is under way, expected none");
  from_ = std::min(from, kMostMargin);
  return {ask()};
}

std::vector<Control> Conductor::appoint() {
  // Ranks that wait come to the next publish in any case, unless they do not wait for long enough.
  const bool waits = awaited_ > 0 && late_ < 2;
  const uint64_t margin = waits ? 0 : counters_.margin;
  last_ = std::max({newest_ + 1 + margin, last_ + 1, planned_, waits ? 0 : from_});
  state_ = State::Collecting;
  step_ = {last_, 0, 0};
  taken_.assign(taken_.size(), false);
  takes_ = 0;
  latest_ = -1;
  completed_.clear();
  counters_.appointed++;
  return {{Control::Kind::Appoint, last_, 0}};
}

// The appointment came too late by newest - count publishes, and the next one is to lie as many further ahead at least. A rank that
// misses it for want of room is not late.
void Conductor::widen(uint64_t newest) {
  counters_.missed++;
  successes_ = 0;
  if (newest < step_.count) return;
  late_++;
  counters_.margin = std::min(std::max(2 * counters_.margin, newest - step_.count + 1), kMostMargin);
}

std::vector<Control> Conductor::receive(int rank, const Control& message) {
  switch (message.kind) {
    case Control::Kind::Newest:
      if ((state_ != State::Asking && state_ != State::Looking) || message.count != question_) return {};
      if (answered_.at(size_t(rank))) return {};
      answered_[size_t(rank)] = true;
      isAt(rank, message.newest);
      answer_ = std::max(answer_, std::min(message.newest, kMostMargin));
      if (++answers_ < answered_.size()) return {};
      newest_ = answer_;
      if (std::exchange(state_, State::Idle) == State::Looking) return {};
      return appoint();
    case Control::Kind::Missed: {
      if (state_ != State::Collecting || message.count != step_.count) return {};
      widen(message.newest);
      const Control cancel{Control::Kind::Cancel, step_.count, 0};
      return {cancel, ask()};
    }
    case Control::Kind::Waits:
      ranksWait_ = true;
      isAt(rank, message.count);
      awaited_ = std::max(awaited_, std::min(message.count, kMostMargin));
      return {};
    default:
      throw Error("control message that only servers send, expected one of a simulation");
  }
}

// A rank says first what it has, and then that it has come so far.
void Conductor::isAt(int rank, uint64_t count) {
  uint64_t& known = known_.at(size_t(rank));
  known = std::max(known, std::min(count, kMostMargin));
}

void Conductor::receive(int rank, const StepHeader& step) {
  isAt(rank, step.count);
  if (state_ != State::Collecting || step.count != step_.count || taken_.at(size_t(rank))) return;
  if (takes_ > 0 && (step_.step != step.step || bitsOf(step_.time) != bitsOf(step.time)))
    throw Error("publish " + std::to_string(step.count) + " is step " + std::to_string(step.step) +
                " with time " + std::to_string(step.time) + " on rank " + std::to_string(rank) +
                ", but step " + std::to_string(step_.step) + " with time " + std::to_string(step_.time) +
                " on another, expected that all ranks publish the same steps in the same order");
  taken_[size_t(rank)] = true;
  takes_++;
  latest_ = rank;
  step_ = step;
}

void Conductor::complete(int owner, uint64_t count) {
  if (state_ == State::Collecting && count == step_.count && owners_.count(owner) > 0)
    completed_.insert(owner);
}

bool Conductor::isComplete() const {
  return state_ == State::Collecting && completed_ == owners_ && takes_ == taken_.size();
}

bool Conductor::someTaken() const { return state_ == State::Collecting && takes_ > 0; }

std::vector<Control> Conductor::again() {
  if (state_ != State::Collecting || takes_ > 0 || counters_.margin == 0 || from_ > 0) return {};
  counters_.margin /= 2;
  const Control cancel{Control::Kind::Cancel, step_.count, 0};
  return {cancel, ask()};
}

std::string Conductor::missing() const {
  std::string ranks, owners;
  for (size_t r = 0; r < taken_.size() && ranks.size() < 100; r++)
    if (!taken_[r]) ranks += " " + std::to_string(r);
  for (const int owner : owners_)
    if (completed_.count(owner) == 0) owners += " " + std::to_string(owner);
  return (ranks.empty() ? "" : "ranks of the simulation that have not published it:" + ranks + "; ") +
         "ranks of the server that lack samples:" + (owners.empty() ? " none" : owners);
}

std::vector<Control> Conductor::published() {
  state_ = State::Idle;
  counters_.published++;
  published_ = step_.count;
  late_ = 0;
  if (++successes_ == kSuccesses) {
    counters_.margin /= 2;
    successes_ = 0;
  }
  return {{Control::Kind::Published, step_.count, 0}};
}

// A rank that has said something new since the plan has not taken the step.
bool Conductor::comesAgain() const {
  const auto isNew = [this](uint64_t from) { return from > planned_; };
  return isHeldUp() && takes_ == 0 && std::all_of(said_.begin(), said_.end(), isNew);
}

std::vector<Control> Conductor::abandon() {
  const bool again = comesAgain();
  const State before = std::exchange(state_, State::Idle);
  if (before == State::Idle || before == State::Looking) return {};
  if (again)
    last_--;
  else
    counters_.abandoned++;
  if (before == State::Asking) return {};
  return {{Control::Kind::Cancel, step_.count, 0}};
}

}  // namespace gxy::insitu
