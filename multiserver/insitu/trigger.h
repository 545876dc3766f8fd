// SPDX-License-Identifier: Apache-2.0
// What is to be done on the server with steps of a stream, and with which of them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace gxy {

/// What is known of a dataset of a step, without a pass over its data.
struct StepValues {
  double
      least = 0,
      largest =
          0;  ///< of the finite values, or of the magnitude of several components; least > largest: there are none
  int64_t noData = 0;  ///< points with a value that is not finite
};

/// A trigger, as a client describes it (docs/insitu.md).
struct Trigger {
  struct Threshold {
    enum class Kind { Above, Below, NoData };
    Kind kind = Kind::Above;
    std::string field;  ///< the dataset is STREAM.field
    double value = 0;
  };
  enum class Does { Batch, Cinema, Event, Steer };

  std::string name;
  int64_t every = 0;  ///< 0: not asked for
  std::vector<Threshold> thresholds;
  Does does = Does::Event;
  /// The document of `viewer.batch`, whose prefix contains {step}, or of `viewer.cinema`, whose `to` may.
  nlohmann::json document;
  std::map<std::string, double> steer;  ///< the values that parameters get
  bool exact = false;                   ///< the next step waits until this is done
};

/// Reads a trigger. Throws Error, with what was expected.
Trigger readTrigger(const nlohmann::json& document);
nlohmann::json written(const Trigger& trigger);

/// Which steps a trigger is for. One thread at a time uses it.
class TriggerCondition {
 public:
  /// The values of a dataset, by field; throws Error if there is none.
  using ValuesOf = std::function<StepValues(const std::string& field)>;

  explicit TriggerCondition(const Trigger& trigger)
      : every_(trigger.every), thresholds_(trigger.thresholds) {}

  /// Takes a published step; steps ascend. All that is asked for must hold. With `every`, the step must be as many steps after the last
  /// one that it was for. Without, the thresholds must not have held at the step before, so that a crossing counts once.
  bool holds(int64_t step, const ValuesOf& valuesOf);
  /// The step that may be the next one; nothing: each may be.
  std::optional<int64_t> next() const;

 private:
  const int64_t every_;
  const std::vector<Trigger::Threshold> thresholds_;
  std::optional<int64_t> last_;  ///< the step that it held for
  bool held_ = false;            ///< the thresholds, at the step before
};

/// Returns a name of files with {step} replaced by the step, of at least 8 digits.
std::string nameAtStep(const std::string& pattern, int64_t step);

/// Returns the statement that a trigger has the server run for a step, or an empty text if it is for none.
std::string statementOf(const Trigger& trigger, int64_t step);

}  // namespace gxy
