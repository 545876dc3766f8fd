// SPDX-License-Identifier: Apache-2.0
// The filter Derive: a field that an expression computes from others.
#pragma once
#include <string>
#include <vector>

#include "core/analysis/evaluate.h"
#include "core/analysis/evaluate_mesh.h"
#include "core/analysis/filter.h"

namespace gxy {

/// Each input is a field under the name that the expression uses (expression.h).
struct Derive {
  std::string expression;

  static FilterInfo info();
  static std::vector<KeyRow<Derive>> properties();
  FilterResult run(FilterRun& run) const;
};

/// The inputs of a run, which are the fields of an expression. Throws Error if there is none.
std::vector<FieldInput> fieldsOf(const FilterRun& run, const std::string& filter);

/// Likewise if the inputs are unstructured volumes; none if they are on grids. Throws Error if there are both.
std::vector<MeshInput> meshFieldsOf(const FilterRun& run, const std::string& filter);

/// Reads a key that is an expression, and checks it as far as that goes without its inputs.
std::string readExpression(const Found& found);

/// Enters memory that a computation needs meanwhile, as DeriveOptions::memory tells it.
class WorkingMemory {
 public:
  explicit WorkingMemory(FilterRun& run) : run_(run) {}
  std::function<void(int64_t bytes)> teller();
  void giveBack() {
    entries_.clear();
    bytes_ = 0;
  }

 private:
  FilterRun& run_;
  std::vector<LedgerEntry> entries_;
  int64_t bytes_ = 0;
};

}  // namespace gxy
