// SPDX-License-Identifier: Apache-2.0
// What windows on the views of a graph show.
#include <algorithm>

#include "core/comm/error.h"
#include "multiserver/graph/graph.h"

namespace gxy {

/// Removes the operators whose data are not there, and returns the data of the others.
SceneCache::GivenData Graph::givenTo(Visualization& visualization, const std::vector<ShownItem>& items,
                                     const std::map<std::string, glm::dvec4>& colors) {
  SceneCache::GivenData given;
  std::erase_if(visualization.operators, [&](const Vis& vis) {
    const auto item =
        std::find_if(items.begin(), items.end(), [&](const ShownItem& i) { return i.node == vis.dataset; });
    if (item == items.end()) return true;
    const auto color = colors.find(vis.dataset);
    given.push_back({item->kept, color == colors.end() ? DatasetSpec().color : color->second});
    return false;
  });
  return given;
}

/// What rendering would refuse. The data of rank 0 say it for all ranks.
std::string Graph::failureOf(const std::vector<ShownItem>& items) const {
  std::shared_ptr<const Partitioning> first;
  for (const ShownItem& item : items) {
    std::shared_ptr<const Partitioning> cut;
    try {
      const ObjectGeneration at = item.kept->where();
      cut = services_.serverRank.objects.pin(at.key, at.generation).get<Dataset>()->partitioning;
    } catch (const Error&) {
      continue;  // A publisher's buffer has just become the graph's own.
    }
    if (!first) first = cut;
    if (first != cut && !(*first == *cut)) return textOfTwoPartitionings(items[0].node, item.node);
  }
  return "";
}

ViewContent Graph::content(uint64_t window) const {
  const std::lock_guard lock(mutex_);
  return contentOf(viewOf_.at(window));
}

ViewContent Graph::content(const std::string& view) const {
  const std::lock_guard lock(mutex_);
  return contentOf(view);
}

ViewContent Graph::contentOf(const std::string& view) const {
  ViewContent content;
  content.serial = serial_;
  content.revision = revision_;
  content.settings = document_.settings;
  if (isEnded_) {
    content.text = "the graph was dropped";
    return content;
  }
  const auto look = document_.looks.find(view);
  if (look == document_.looks.end()) {
    content.text = "the graph has no view " + inQuotes(view);
    return content;
  }
  content.camera = look->second.camera;
  content.size = look->second.size;
  const auto shown = shown_.find(view);
  content.text = shown == shown_.end() ? "its data are not there yet" : shown->second.text;
  if (shown == shown_.end() || shown->second.isHeld) return content;
  if (!shown->second.failure.empty()) {
    content.text = shown->second.failure;
    return content;
  }
  Visualization visualization = look->second.visualization;
  std::map<std::string, glm::dvec4> colors;
  for (const DatasetSpec& d : document_.flow.datasets) colors[d.name] = d.color;
  content.data = givenTo(visualization, shown->second.items, colors);
  if (!content.data.empty()) content.visualization = std::move(visualization);
  if (content.data.empty() && content.text.empty()) content.text = "it shows none of what is there";
  return content;
}

}  // namespace gxy
