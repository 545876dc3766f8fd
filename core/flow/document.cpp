// SPDX-License-Identifier: Apache-2.0
#include "core/flow/document.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/comm/error_text.h"

namespace gxy::flow {
namespace {

Defect missingName(const std::string& node, const std::string& dataset) {
  return {Defect::Kind::Incomplete, node, "there is no dataset " + inQuotes(dataset)};
}

}  // namespace

CompiledDocument::CompiledDocument(const Document& document, const FilterSchemas& filters)
    : document_(document) {
  checkNamesAndLimits(document);
  checkTypes(document, filters);
  order_ = evaluationOrder(document.datasets);
  for (size_t i = 0; i < document.datasets.size(); i++) places_.emplace_back(document.datasets[i].name, i);
  std::sort(places_.begin(), places_.end());
  for (const DatasetSpec& dataset : document.datasets) nodes_.push_back({dataset, 1, {}, {}});
  for (size_t i = 0; i < nodes_.size(); i++)
    if (!nodes_[i].isSource()) compileNode(i, filters);
  findDefects();
  for (const ViewSpec& view : document.views) {
    targets_.push_back(show({TargetId::Kind::View, view.name}, view.datasets));
    targets_.back().follow = view.follow;
    targets_.back().asItComes = view.asItComes;
  }
  for (const OutputSpec& output : document.outputs) {
    std::vector<std::string> datasets{output.of};
    for (const ViewSpec& view : document.views)
      if (view.name == output.of && !place(output.of)) datasets = view.datasets;
    targets_.push_back(show({TargetId::Kind::Output, output.name}, datasets));
  }
}

void CompiledDocument::compileNode(size_t at, const FilterSchemas& filters) {
  Node& node = nodes_[at];
  const std::string& name = node.spec.name;
  const FilterSchema* filter = filters.find(node.spec.filter);
  if (!filter) {
    node.defect = {Defect::Kind::Blocked, name, "there is no filter " + inQuotes(node.spec.filter)};
    return;
  }
  node.version = filter->version;
  if (filter->makes) node.spec.type = *filter->makes;
  for (const FilterInput& input : node.spec.inputs) {
    Node::Port port{input.input, filter->port(input.input)->types, {}};
    for (const std::string& dataset : input.datasets) {
      if (const auto found = place(dataset))
        port.places.push_back(*found);
      else if (node.defect.kind == Defect::Kind::None)
        node.defect = {Defect::Kind::Incomplete, name,
                       "input " + inQuotes(input.input, '`') + ": there is no dataset " + inQuotes(dataset)};
    }
    node.ports.push_back(std::move(port));
  }
  std::sort(node.ports.begin(), node.ports.end(),
            [](const Node::Port& a, const Node::Port& b) { return a.input < b.input; });
  std::string missing;
  const auto properties = canonicalProperties(node.spec, *filter, missing, warnings_);
  if (properties)
    node.spec.properties = *properties;
  else
    node.defect = {Defect::Kind::Incomplete, name, "property " + inQuotes(missing, '`') + " is missing"};
  if (const auto inputs = missingInputs(*filter, node.spec); !inputs.empty())
    node.defect = {
        Defect::Kind::Incomplete, name,
        "input " + inQuotes(inputs[0]->name, '`') + " is missing, expected " + namesOf(inputs[0]->types)};
}

void CompiledDocument::findDefects() {
  for (size_t at : order_)
    for (const Node::Port& port : nodes_[at].ports)
      for (size_t read : port.places)
        if (nodes_[at].defect.kind == Defect::Kind::None && nodes_[read].defect.kind != Defect::Kind::None)
          nodes_[at].defect = {Defect::Kind::Blocked, nodes_[read].defect.node, nodes_[read].defect.text};
}

std::optional<size_t> CompiledDocument::place(const std::string& dataset) const {
  const auto found = std::lower_bound(places_.begin(), places_.end(), std::pair(dataset, size_t{0}));
  if (found == places_.end() || found->first != dataset) return std::nullopt;
  return found->second;
}

const Target* CompiledDocument::target(const TargetId& id) const {
  const auto found =
      std::find_if(targets_.begin(), targets_.end(), [&](const Target& target) { return target.id == id; });
  return found == targets_.end() ? nullptr : &*found;
}

Target CompiledDocument::show(TargetId id, const std::vector<std::string>& datasets) const {
  Target target;
  target.id = std::move(id);
  for (const std::string& dataset : datasets) {
    const auto found = place(dataset);
    if (!found)
      target.missing.push_back(missingName(dataset, dataset));
    else if (std::count(target.shows.begin(), target.shows.end(), *found) == 0)
      target.shows.push_back(*found);
  }
  close(target);
  return target;
}

Target CompiledDocument::only(size_t node) const {
  Target target;
  target.id = {TargetId::Kind::Run, nodes_[node].spec.name};
  target.shows = {node};
  close(target);
  return target;
}

std::vector<Target> CompiledDocument::everything() const {
  std::vector<bool> isRead(nodes_.size());
  for (const Node& node : nodes_)
    if (node.canEvaluate())
      for (const Node::Port& port : node.ports)
        for (size_t read : port.places) isRead[read] = true;
  std::vector<Target> out;
  for (size_t at : order_)
    if (nodes_[at].canEvaluate() && !isRead[at]) out.push_back(only(at));
  return out;
}

void CompiledDocument::close(Target& target) const {
  std::vector<bool> isNeeded(nodes_.size());
  const auto need = [&](size_t node) {
    isNeeded[node] = isNeeded[node] || nodes_[node].defect.kind == Defect::Kind::None;
  };
  for (size_t shown : target.shows) need(shown);
  for (auto at = order_.rbegin(); at != order_.rend(); ++at)
    if (isNeeded[*at])
      for (const Node::Port& port : nodes_[*at].ports)
        for (size_t read : port.places) need(read);
  for (size_t i = 0; i < nodes_.size(); i++)
    if (isNeeded[i] && nodes_[i].isSource()) target.sources.push_back(i);
  target.closure = target.sources;
  for (size_t at : order_)
    if (isNeeded[at]) target.closure.push_back(at);
}

}  // namespace gxy::flow
