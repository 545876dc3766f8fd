// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/series.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/comm/error.h"
#include "core/scene/json_text.h"

namespace gxy {

using nlohmann::json;

namespace {

/// Whether a byte of UTF-8 continues the character of the byte before it.
bool isInside(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

/// Returns a common name for all files: the beginning and the end that their names share, and * for the rest.
/// It is empty if they share neither.
std::string commonName(const std::vector<std::string>& stems) {
  std::string begin = stems.front(), end = begin;
  for (const std::string& stem : stems) {
    begin.erase(std::mismatch(begin.begin(), begin.end(), stem.begin(), stem.end()).first, begin.end());
    const auto differs = std::mismatch(end.rbegin(), end.rend(), stem.rbegin(), stem.rend()).first;
    end.erase(end.begin(), differs.base());
  }
  if (begin == stems.front() && end == begin) return begin;  // All names are equal.
  while (!begin.empty() && isInside(stems.front()[begin.size()])) begin.pop_back();
  size_t shortest = stems.front().size();
  for (const std::string& stem : stems) shortest = std::min(shortest, stem.size());
  end.erase(0, end.size() - std::min(end.size(), shortest - begin.size()));
  while (!end.empty() && isInside(end.front())) end.erase(end.begin());
  return begin.empty() && end.empty() ? "" : begin + "*" + end;
}

std::string nameOf(const std::string& dataset, const std::vector<Series::Step>& steps) {
  std::vector<std::string> stems;
  for (const Series::Step& step : steps)
    if (const auto file = step.files.find(dataset); file != step.files.end())
      stems.push_back(std::filesystem::path(file->second).stem().string());
  const std::string common = stems.empty() ? "" : commonName(stems);
  return common.empty() ? dataset : common;
}

std::string freeName(const std::string& name, const std::set<std::string>& taken) {
  std::string called = name;
  for (int n = 2; taken.contains(called); n++) called = name + "-" + std::to_string(n);
  return called;
}

}  // namespace

std::vector<DatasetSpec> Series::datasetsAt(size_t step) const {
  std::vector<DatasetSpec> datasets = datasets_;
  for (DatasetSpec& dataset : datasets)
    if (const auto file = steps_[step].files.find(dataset.name); file != steps_[step].files.end())
      dataset.filename = file->second;
  return datasets;
}

std::string Series::textOf(size_t step) const {
  const std::optional<double> time = timeOf(step);
  return "step " + std::to_string(step + 1) + " of " + std::to_string(count()) +
         (time ? ", time " + numberText(*time) : "");
}

void Series::next(int by) {
  const auto inside = [&](ptrdiff_t step) { return step >= 0 && step < ptrdiff_t(count()); };
  ptrdiff_t to = ptrdiff_t(wanted_) + by;
  if (failed_ && to == ptrdiff_t(*failed_) && inside(to + by)) to += by;
  if (inside(to)) wanted_ = size_t(to);
}

size_t Series::stepOf(uint64_t generation) const {
  const auto at = byGeneration_.find(generation);
  return at == byGeneration_.end() ? there_ : at->second;
}

std::optional<size_t> Series::begin() {
  if (underWay_ || wanted_ == there_) return std::nullopt;
  underWay_ = wanted_;
  byGeneration_[generation_ + 1] = *underWay_;  // Its pictures may come before end() is called.
  return underWay_;
}

size_t Series::end(bool came, std::optional<uint64_t> generation) {
  const size_t step = *underWay_;
  underWay_.reset();
  if (!came) {
    failed_ = step;
    byGeneration_.erase(generation_ + 1);
    if (wanted_ == step) wanted_ = there_;
    return step;
  }
  failed_.reset();
  there_ = step;
  byGeneration_.erase(generation_ + 1);
  // The generation before may still be shown. Older ones are over, or belong to another dataset that had the name.
  std::erase_if(byGeneration_, [&](const auto& each) { return each.first != generation_; });
  generation_ = generation.value_or(generation_ + 1);
  byGeneration_[generation_] = step;
  return step;
}

std::vector<Series::Step> stepsFrom(const json& steps) {
  const auto expectThat = [&](bool right) {
    if (!right)
      throw Error("viewer.scene: `steps`: expected a list of objects with `time` and `files`, found " +
                  steps.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 200));
  };
  std::vector<Series::Step> out;
  expectThat(steps.is_array() && !steps.empty());
  for (const json& step : steps) {
    expectThat(step.is_object() && step.contains("files") && step["files"].is_object());
    Series::Step& to = out.emplace_back();
    if (const json time = step.value("time", json()); time.is_number()) to.time = time.get<double>();
    for (const auto& [dataset, file] : step["files"].items()) {
      expectThat(file.is_string());
      to.files[dataset] = file.get<std::string>();
    }
  }
  return out;
}

Series makeSeries(State& state, std::vector<Series::Step> steps, std::set<std::string> taken) {
  std::map<std::string, std::string> names;
  for (DatasetSpec& dataset : state.datasets) {
    const std::string name = freeName(nameOf(dataset.name, steps), taken);
    taken.insert(name);
    names[dataset.name] = name;
    dataset.name = name;
  }
  for (Visualization& visualization : state.visualizations)
    for (Vis& vis : visualization.operators)
      if (const auto name = names.find(vis.dataset); name != names.end()) vis.dataset = name->second;
  for (Series::Step& step : steps) {
    std::map<std::string, std::string> files;
    for (auto& [dataset, file] : step.files)
      if (const auto name = names.find(dataset); name != names.end()) files[name->second] = std::move(file);
    step.files = std::move(files);
  }
  return {state.datasets, std::move(steps)};
}

}  // namespace gxy
