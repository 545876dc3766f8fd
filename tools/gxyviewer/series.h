// SPDX-License-Identifier: Apache-2.0
// Time steps of data: which step is loaded, which is wanted, and which is being imported.
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

/// The time steps of the shown data. The first is loaded initially. One step is imported at a time; if
/// others are wanted meanwhile, the last of them is imported next. If the import of a step fails, the step
/// before stays loaded.
class Series {
 public:
  struct Step {
    std::optional<double> time;                ///< absent if unknown
    std::map<std::string, std::string> files;  ///< by dataset, for those with a file for each step
  };

  /// Data with a single step.
  Series() : Series({}, std::vector<Step>(1)) {}
  /// `datasets` are those of the first step. There is at least one step.
  Series(std::vector<DatasetSpec> datasets, std::vector<Step> steps)
      : datasets_(std::move(datasets)), steps_(std::move(steps)) {}

  size_t count() const { return steps_.size(); }
  std::optional<double> timeOf(size_t step) const { return steps_[step].time; }
  /// Returns all datasets with their files in a step.
  std::vector<DatasetSpec> datasetsAt(size_t step) const;
  /// Returns text for users: "step 2 of 9, time 0.25".
  std::string textOf(size_t step) const;

  // The wanted step. next() stays within the first and the last step, and skips the step whose import failed
  // last, if there is another one behind it.
  void next(int by);
  void first() { wanted_ = 0; }
  void last() { wanted_ = steps_.size() - 1; }
  size_t wanted() const { return wanted_; }

  /// The step that was loaded last, and the generation of its datasets.
  size_t there() const { return there_; }
  uint64_t generation() const { return generation_; }
  /// Returns the step that a generation of the datasets belongs to; the loaded step for an unknown generation.
  size_t stepOf(uint64_t generation) const;

  /// Returns the step to import now, if there is one. It then is under way until end().
  std::optional<size_t> begin();
  /// Ends the import of the step under way and returns that step. `came`: it has succeeded, as `generation`
  /// of the datasets, or as the next generation if that is not known.
  size_t end(bool came, std::optional<uint64_t> generation = {});

 private:
  std::vector<DatasetSpec> datasets_;
  std::vector<Step> steps_;
  size_t there_ = 0, wanted_ = 0;
  std::optional<size_t> underWay_, failed_;
  uint64_t generation_ = 1;
  std::map<uint64_t, size_t> byGeneration_{{1, 0}};
};

/// Returns the steps in `steps` of a reply to viewer.scene. Throws Error if it is malformed.
std::vector<Series::Step> stepsFrom(const nlohmann::json& steps);

/// Makes a series and renames the state's datasets to names that are not in `taken`. The names are new
/// because the datasets' data will change, and other clients that show these files must not see that. The new
/// name is that of the dataset's files; if they have different names, * stands for the part that differs.
Series makeSeries(State& state, std::vector<Series::Step> steps, std::set<std::string> taken);

}  // namespace gxy
