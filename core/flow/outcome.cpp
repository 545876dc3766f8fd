// SPDX-License-Identifier: Apache-2.0
#include "core/flow/outcome.h"

#include <algorithm>
#include <utility>

#include "core/comm/error_text.h"

namespace gxy::flow {
namespace {

// A source's data that the filter does not take: a name can come to mean a dataset of another type.
std::optional<Problem> wrongType(const CompiledDocument& document, const Node& node, const Step& step) {
  for (const Node::Port& port : node.ports)
    for (size_t read : port.places) {
      const std::string& name = document.nodes()[read].spec.name;
      const auto data = step.find(name);
      if (!document.nodes()[read].isSource() || data == step.end()) continue;
      if (port.types & bitOf(data->second.type)) continue;
      return Problem{node.spec.name, "input " + inQuotes(port.input, '`') + ": expected " +
                                         namesOf(port.types) + ", found " + inQuotes(name) + ", which is " +
                                         namesOf(bitOf(data->second.type))};
    }
  return std::nullopt;
}

Outcome outcomeOfSource(const Node& node, const Step& step, const Stock& stock) {
  Outcome outcome;
  if (const auto data = step.find(node.spec.name); data != step.end()) {
    outcome.kind = Outcome::Kind::There;
    outcome.data = data->second.id;
    return outcome;
  }
  const auto failure = stock.sourceFailures.find(node.spec.name);
  outcome.kind = Outcome::Kind::Problem;
  outcome.isCause = true;
  outcome.problem =
      failure != stock.sourceFailures.end() ? failure->second : Problem{node.spec.name, "it is not there"};
  return outcome;
}

Outcome outcomeOfFilter(const CompiledDocument& document, const Node& node, const std::optional<NodeKey>& key,
                        const std::vector<Outcome>& outcomes, const Step& step, const Stock& stock) {
  using Kind = Outcome::Kind;
  if (const auto problem = wrongType(document, node, step)) return {Kind::Problem, {}, *problem, true};
  if (key && stock.outputs.find(*key)) return {Kind::There, *key, {}, false};
  if (const Problem* failure = key ? stock.failures.find(*key) : nullptr) {
    Problem problem = *failure;
    problem.node = node.spec.name;  // equal nodes fail together
    return {Kind::Problem, {}, problem, true};
  }
  for (const Node::Port& port : node.ports)
    for (size_t read : port.places)
      if (outcomes[read].kind == Kind::Problem) return {Kind::Problem, {}, outcomes[read].problem, false};
  return {Kind::Pending, {}, {}, false};
}

void addProblem(Picture& picture, const Problem& problem) {
  if (std::find(picture.problems.begin(), picture.problems.end(), problem) == picture.problems.end())
    picture.problems.push_back(problem);
}

}  // namespace

NodeKeys::NodeKeys(std::shared_ptr<const CompiledDocument> document)
    : document_(std::move(document)), last_(document_->nodes().size()) {}

std::vector<std::optional<NodeKey>> NodeKeys::of(const std::vector<size_t>& closure, const Step& step) {
  const std::vector<Node>& nodes = document_->nodes();
  std::vector<std::optional<NodeKey>> keys(nodes.size());
  for (size_t at : closure) {
    const Node& node = nodes[at];
    if (!node.canEvaluate()) continue;
    std::vector<KeyInput> inputs;
    bool isComplete = true;
    for (const Node::Port& port : node.ports) {
      KeyInput& input = inputs.emplace_back();
      input.input = port.input;
      for (size_t read : port.places) {
        const auto source = step.find(nodes[read].spec.name);
        if (nodes[read].isSource() && source != step.end())
          input.data.emplace_back(source->second.id);
        else if (!nodes[read].isSource() && keys[read])
          input.data.emplace_back(*keys[read]);
        else
          isComplete = false;
      }
    }
    if (!isComplete) continue;
    std::optional<Last>& last = last_[at];
    if (!last || last->inputs != inputs)
      last = Last{inputs, keyOf(node.spec.filter, node.version, node.spec.properties, inputs)};
    keys[at] = last->key;
  }
  return keys;
}

std::vector<Outcome> outcomes(NodeKeys& keys, const std::vector<size_t>& closure, const Step& step,
                              const Stock& stock) {
  const CompiledDocument& document = keys.document();
  const auto keyOfNode = keys.of(closure, step);
  std::vector<Outcome> out(document.nodes().size());
  for (size_t at : closure) {
    const Node& node = document.nodes()[at];
    out[at] = node.isSource() ? outcomeOfSource(node, step, stock)
                              : outcomeOfFilter(document, node, keyOfNode[at], out, step, stock);
  }
  return out;
}

Picture pictureOf(const CompiledDocument& document, const Target& target,
                  const std::vector<Outcome>& outcomes, const Step& step, const Stock& stock) {
  Picture picture;
  std::vector<Origin> origins;
  for (const Defect& missing : target.missing) addProblem(picture, {missing.node, missing.text});
  std::vector<size_t> older;
  for (size_t shown : target.shows) {
    const Node& node = document.nodes()[shown];
    const Outcome& outcome = outcomes[shown];
    if (node.defect.kind != Defect::Kind::None) {
      addProblem(picture, {node.defect.node, node.defect.text});
    } else if (outcome.kind == Outcome::Kind::There) {
      picture.data.push_back({node.spec.name, outcome.data, false});
      const NodeKey* key = std::get_if<NodeKey>(&outcome.data);
      origins = joined(origins, key ? stock.outputs.find(*key)->origins : originsOf(step.at(node.spec.name)));
    } else {
      if (outcome.kind == Outcome::Kind::Problem) addProblem(picture, outcome.problem);
      if (outcome.kind == Outcome::Kind::Pending) picture.isPending = true;
      if (outcome.kind == Outcome::Kind::Problem || target.asItComes) older.push_back(shown);
    }
  }
  for (size_t shown : older) {
    const std::string& name = document.nodes()[shown].spec.name;
    const auto last = stock.lastGood.find(name);
    const Outputs::Output* output = last == stock.lastGood.end() ? nullptr : stock.outputs.find(last->second);
    if (!output || areMixed(origins, output->origins)) continue;
    origins = joined(origins, output->origins);
    picture.data.push_back({name, last->second, true});
  }
  return picture;
}

}  // namespace gxy::flow
