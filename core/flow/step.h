// SPDX-License-Identifier: Apache-2.0
// Which generations of sources belong together.
#pragma once
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/data/dataset.h"
#include "core/flow/node_key.h"
#include "core/scene/scene.h"

namespace gxy::flow {

/// One generation of a source, as the host tells of it.
struct SourceData {
  SourceGeneration id;
  DatasetType type = DatasetType::Volume;
  std::vector<Origin> origins{};  ///< Dataset::origins; empty: it is its own origin
  bool operator==(const SourceData&) const = default;
};

/// The generation of each source that a wave sees, by the source's name. No two of them are of different steps of one publisher.
using Step = std::map<std::string, SourceData>;

/// Returns the origins of data that have none: their object, and their generation as its step.
std::vector<Origin> originsOf(const SourceData& data);

/// Whether the two, which are sorted, are of different steps of one publisher.
bool areMixed(std::span<const Origin> a, std::span<const Origin> b);
/// Returns the union of origins that are not mixed, sorted.
std::vector<Origin> joined(std::span<const Origin> a, std::span<const Origin> b);

/// Whether one wave can see both: they have the same generations of the same sources, and mix nothing.
bool areOneStep(const Step& a, const Step& b);

/// What there is of each source: newest first, and not empty.
using Candidates = std::map<std::string, std::vector<SourceData>>;

/// Returns for each source the newest candidate that goes with the others. If there is no such step, returns nothing and says in `conflict`
/// which two sources disagree.
///
/// Every source begins with its newest candidate. As long as two have different steps of one publisher, those with the later step go on to
/// their next candidate. Of a publisher whose steps ascend this finds the newest step that is complete: a source that went on could not
/// have stayed, because the other one has nothing newer.
std::optional<Step> newestStep(const Candidates& candidates, std::string& conflict);

}  // namespace gxy::flow
