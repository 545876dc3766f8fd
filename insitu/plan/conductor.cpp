// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/conductor.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {
constexpr int kSuccesses = 16;  // in a row, after which the margin is halved

uint64_t bitsOf(double time) {
  return std::bit_cast<uint64_t>(time);
}  // NaN, for an unknown time, equals NaN
}  // namespace

Conductor::Conductor(int ranks, std::set<int> owners)
    : owners_(std::move(owners)), newest_(size_t(ranks)), taken_(size_t(ranks)) {}

Control Conductor::ask() {
  state_ = State::Asking;
  std::fill(newest_.begin(), newest_.end(), std::nullopt);
  return {Control::Kind::AskNewest, ++question_, 0};
}

std::vector<Control> Conductor::begin() {
  if (state_ != State::Idle) throw Error("a step is under way, expected none");
  return {ask()};
}

std::vector<Control> Conductor::appoint() {
  uint64_t newest = 0;
  for (const auto& told : newest_) newest = std::max(newest, *told);
  last_ = std::max(newest + 1 + counters_.margin, last_ + 1);
  state_ = State::Collecting;
  step_ = {last_, 0, 0};
  std::fill(taken_.begin(), taken_.end(), std::nullopt);
  completed_.clear();
  counters_.appointed++;
  return {{Control::Kind::Appoint, last_, 0}};
}

// The appointment came too late by newest - count publishes, and the next one is to lie as many further ahead at least.
void Conductor::widen(uint64_t newest) {
  const uint64_t late = newest > step_.count ? newest - step_.count : 0;
  counters_.margin = std::max(2 * counters_.margin, late + 1);
  counters_.missed++;
  successes_ = 0;
}

std::vector<Control> Conductor::receive(int rank, const Control& message) {
  switch (message.kind) {
    case Control::Kind::Newest:
      if (state_ != State::Asking || message.count != question_) return {};
      newest_.at(size_t(rank)) = message.newest;
      if (std::all_of(newest_.begin(), newest_.end(), [](const auto& told) { return told.has_value(); }))
        return appoint();
      return {};
    case Control::Kind::Missed: {
      if (state_ != State::Collecting || message.count != step_.count) return {};
      widen(message.newest);
      const Control cancel{Control::Kind::Cancel, step_.count, 0};
      return {cancel, ask()};
    }
    default:
      throw Error("control message that only servers send, expected one of a simulation");
  }
}

void Conductor::receive(int rank, const StepHeader& step) {
  if (state_ != State::Collecting || step.count != step_.count) return;
  for (const auto& other : taken_)
    if (other && (other->step != step.step || bitsOf(other->time) != bitsOf(step.time)))
      throw Error("publish " + std::to_string(step.count) + " is step " + std::to_string(step.step) +
                  " with time " + std::to_string(step.time) + " on rank " + std::to_string(rank) +
                  ", but step " + std::to_string(other->step) + " with time " + std::to_string(other->time) +
                  " on another, expected that all ranks publish the same steps in the same order");
  taken_.at(size_t(rank)) = step;
  step_ = step;
}

void Conductor::complete(int owner, uint64_t count) {
  if (state_ == State::Collecting && count == step_.count && owners_.count(owner) > 0)
    completed_.insert(owner);
}

bool Conductor::isComplete() const {
  return state_ == State::Collecting && completed_ == owners_ &&
         std::all_of(taken_.begin(), taken_.end(), [](const auto& t) { return t.has_value(); });
}

bool Conductor::someTaken() const {
  return state_ == State::Collecting &&
         std::any_of(taken_.begin(), taken_.end(), [](const auto& t) { return t.has_value(); });
}

std::string Conductor::missing() const {
  std::string ranks, owners;
  for (size_t r = 0; r < taken_.size(); r++)
    if (!taken_[r]) ranks += " " + std::to_string(r);
  for (const int owner : owners_)
    if (completed_.count(owner) == 0) owners += " " + std::to_string(owner);
  return (ranks.empty() ? "" : "ranks of the simulation that have not published it:" + ranks + "; ") +
         "ranks of the server that lack samples:" + (owners.empty() ? " none" : owners);
}

std::vector<Control> Conductor::published() {
  state_ = State::Idle;
  counters_.published++;
  if (++successes_ == kSuccesses) {
    counters_.margin /= 2;
    successes_ = 0;
  }
  return {{Control::Kind::Published, step_.count, 0}};
}

std::vector<Control> Conductor::abandon() {
  const State before = std::exchange(state_, State::Idle);
  if (before == State::Idle) return {};
  counters_.abandoned++;
  if (before == State::Asking) return {};
  return {{Control::Kind::Cancel, step_.count, 0}};
}

}  // namespace gxy::insitu
