// SPDX-License-Identifier: Apache-2.0
// Random documents and random edits of them.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "core/comm/random.h"
#include "core/flow/document.h"
#include "tests/flow/filters.h"

namespace gxy::test {

/// Draws documents about sources named s0, s1, ...: chains, diamonds, equal nodes, views and outputs.
class RandomDocument {
 public:
  RandomDocument(Random& random, size_t sources) : random_(random), sources_(sources) {
    for (size_t i = 0; i < sources_; i++) document_.datasets.push_back(live("s" + std::to_string(i)));
    if (random_.oneIn(8)) {
      addChain(20);
    } else {
      for (uint64_t left = 1 + random_.below(8); left > 0; left--) addNode();
    }
    for (uint64_t i = 0; i < 3; i++) addView("v" + std::to_string(i));
    if (random_.oneIn(3)) document_.outputs.push_back({"o0", anyDataset()});
    if (random_.oneIn(8)) document_.outputs.push_back({"o1", "v0"});
  }

  const flow::Document& document() const { return document_; }

  /// Changes something, and perhaps goes back to what was there before.
  void edit() {
    const flow::Document before = document_;
    if (random_.oneIn(6) && !history_.empty()) {
      document_ = history_[random_.below(history_.size())];
    } else {
      for (uint64_t left = 1 + random_.below(2); left > 0; left--) change();
    }
    history_.push_back(before);
  }
  /// A slider moves: the same property again and again.
  void slide() {
    for (DatasetSpec& dataset : document_.datasets)
      if (!dataset.filter.empty()) return setAmount(dataset);
  }

 private:
  std::string amount() { return R"({"by":)" + std::to_string(random_.below(4)) + "}"; }
  void setAmount(DatasetSpec& dataset) {
    if (!dataset.filter.empty()) dataset.properties = amount();
  }

  const std::string& anyDataset() {
    return document_.datasets[random_.below(document_.datasets.size())].name;
  }

  // Inputs are of datasets that stand before, so that there is no cycle.
  std::string datasetBefore(size_t place) { return document_.datasets[random_.below(place)].name; }

  std::vector<FilterInput> inputs(const std::string& filter, size_t place) {
    if (filter == "Shift") return {{"field", {datasetBefore(place)}}};
    std::vector<std::string> names;
    for (uint64_t left = 1 + random_.below(3); left > 0; left--) names.push_back(datasetBefore(place));
    return {{"fields", names}};
  }

  void addNode() {
    const std::string filter = random_.oneIn(2) ? "Shift" : "Add";
    const size_t place = document_.datasets.size();
    document_.datasets.push_back(made(freshName(), filter, inputs(filter, place), amount()));
  }

  void addChain(size_t length) {
    std::string last = anyDataset();
    for (; length > 0; length--) {
      const std::string name = freshName();
      document_.datasets.push_back(made(name, "Shift", {{"field", {last}}}, amount()));
      last = name;
    }
  }

  void addView(const std::string& name) {
    flow::ViewSpec view{name, {}, !random_.oneIn(5), random_.oneIn(5)};
    for (uint64_t left = 1 + random_.below(3); left > 0; left--) view.datasets.push_back(anyDataset());
    document_.views.push_back(view);
  }

  void change() {
    std::vector<DatasetSpec>& datasets = document_.datasets;
    const size_t place = sources_ + random_.below(datasets.size() - sources_ + 1);
    switch (random_.below(8)) {
      case 0:
        return addNode();
      case 1:  // its consumers become incomplete
        if (datasets.size() > sources_ + 1 && place < datasets.size())
          datasets.erase(datasets.begin() + std::ptrdiff_t(place));
        return;
      case 2:
        if (place < datasets.size()) datasets[place].inputs = inputs(datasets[place].filter, place);
        return;
      case 3:
        if (!document_.views.empty()) {
          document_.views.erase(document_.views.begin() +
                                std::ptrdiff_t(random_.below(document_.views.size())));
        }
        return;
      case 4:
        if (document_.views.size() < 3) addView(freshView());
        return;
      case 5:
        if (!document_.views.empty())
          document_.views[random_.below(document_.views.size())].datasets = {anyDataset(), anyDataset()};
        return;
      default:
        if (place < datasets.size()) setAmount(datasets[place]);
    }
  }

  std::string freshName() { return "n" + std::to_string(next_++); }
  std::string freshView() {
    for (int i = 0;; i++) {
      const std::string name = "v" + std::to_string(i);
      if (std::none_of(document_.views.begin(), document_.views.end(),
                       [&](const flow::ViewSpec& view) { return view.name == name; }))
        return name;
    }
  }

  Random& random_;
  size_t sources_;
  flow::Document document_;
  std::vector<flow::Document> history_;
  int next_ = 0;
};

}  // namespace gxy::test
