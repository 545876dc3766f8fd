// SPDX-License-Identifier: Apache-2.0
#include "core/flow/step.h"

#include <algorithm>
#include <iterator>

#include "core/comm/error_text.h"

namespace gxy::flow {
namespace {

struct Least {
  int64_t step;
  std::string source;  // which has it
};
using LeastSteps = std::map<uint64_t, Least>;  // by publisher

std::string conflictOf(const std::string& source, int64_t step, const Least& least) {
  return inQuotes(least.source) + " is of step " + std::to_string(least.step) + " and " + inQuotes(source) +
         " of step " + std::to_string(step) + " of the same publisher";
}

}  // namespace

std::vector<Origin> originsOf(const SourceData& data) {
  if (data.origins.empty()) return {{data.id.object.value, int64_t(data.id.generation)}};
  return data.origins;
}

bool areMixed(std::span<const Origin> a, std::span<const Origin> b) {
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].source == b[j].source && a[i].step != b[j].step) return true;
    a[i] < b[j] ? i++ : j++;
  }
  return false;
}

std::vector<Origin> joined(std::span<const Origin> a, std::span<const Origin> b) {
  std::vector<Origin> out;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

bool areOneStep(const Step& a, const Step& b) {
  std::map<uint64_t, int64_t> steps;
  for (const auto& [name, data] : a) {
    if (const auto same = b.find(name); same != b.end() && same->second.id != data.id) return false;
    for (const Origin& origin : originsOf(data)) steps[origin.source] = origin.step;
  }
  for (const auto& [name, data] : b)
    for (const Origin& origin : originsOf(data))
      if (const auto found = steps.find(origin.source); found != steps.end() && found->second != origin.step)
        return false;
  return true;
}

std::optional<Step> newestStep(const Candidates& candidates, std::string& conflict) {
  std::map<std::string, size_t> chosen;
  const auto choice = [&](const std::string& name) -> const SourceData& {
    return candidates.at(name)[chosen[name]];
  };
  for (bool changed = true; changed;) {
    changed = false;
    LeastSteps least;
    for (const auto& [name, list] : candidates)
      for (const Origin& origin : originsOf(choice(name)))
        if (const auto [at, isNew] = least.try_emplace(origin.source, Least{origin.step, name});
            !isNew && origin.step < at->second.step)
          at->second = {origin.step, name};
    for (const auto& [name, list] : candidates)
      for (const Origin& origin : originsOf(choice(name))) {
        if (origin.step == least.at(origin.source).step) continue;
        if (++chosen[name] == list.size()) {
          conflict = conflictOf(name, origin.step, least.at(origin.source));
          return std::nullopt;
        }
        changed = true;
        break;
      }
  }
  Step step;
  for (const auto& [name, list] : candidates) step.emplace(name, choice(name));
  return step;
}

}  // namespace gxy::flow
