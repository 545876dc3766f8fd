// SPDX-License-Identifier: Apache-2.0
// Data in time: which step is there, which is wanted, and which is on its way.
#pragma once
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// The steps of the data that are shown, of which the first is there at first. One is asked for at a time; of those that are
/// wanted meanwhile, the last is asked for then. One that cannot be had leaves that before it there.
class Series {
 public:
  struct Step {
    std::optional<double> time;                ///< where it is known
    std::map<std::string, std::string> files;  ///< by dataset, of those that have others in each step
  };

  /// Data of one step.
  Series() : Series({}, std::vector<Step>(1)) {}
  /// `datasets`: as the first step has them. There is a step at least.
  Series(std::vector<DatasetSpec> datasets, std::vector<Step> steps)
      : datasets_(std::move(datasets)), steps_(std::move(steps)) {}

  size_t count() const { return steps_.size(); }
  std::optional<double> timeOf(size_t step) const { return steps_[step].time; }
  /// All datasets with the files that they have in a step.
  std::vector<DatasetSpec> datasetsAt(size_t step) const;
  /// "step 2 of 9, time 0.25", for people.
  std::string textOf(size_t step) const;

  // What is wanted. Beyond the first and the last there is none. One that could not be had last is passed by, if there is
  // another behind it.
  void next(int by);
  void first() { wanted_ = 0; }
  void last() { wanted_ = steps_.size() - 1; }
  size_t wanted() const { return wanted_; }

  /// The newest that is there, and the generation of its datasets.
  size_t there() const { return there_; }
  uint64_t generation() const { return generation_; }
  /// The step whose datasets have a generation; the newest of one that this has not brought about.
  size_t stepOf(uint64_t generation) const;

  /// The step that is to be asked for, if any: it is under way from now on.
  std::optional<size_t> begin();
  /// The one under way has come, as a generation of its datasets (the next one, where it is not known), or has not. Which that
  /// was.
  size_t end(bool came, std::optional<uint64_t> generation = {});

 private:
  std::vector<DatasetSpec> datasets_;
  std::vector<Step> steps_;
  size_t there_ = 0, wanted_ = 0;
  std::optional<size_t> underWay_, failed_;
  uint64_t generation_ = 1;
  std::map<uint64_t, size_t> byGeneration_{{1, 0}};
};

/// What a server says of steps, viewer.scene's `steps`. Throws Error for what is none of that.
std::vector<Series::Step> stepsFrom(const nlohmann::json& steps);

/// The series that a state shows: its datasets get names of their own, which are not in `taken`, as their data will change, and
/// whoever else shows these files is not to see that. Where a dataset's files have different names, * stands for what differs.
Series makeSeries(State& state, std::vector<Series::Step> steps, std::set<std::string> taken);

}  // namespace gxy
