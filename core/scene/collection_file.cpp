// SPDX-License-Identifier: Apache-2.0
#include "core/scene/collection_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/read_context.h"
#include "core/scene/xml_tags.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;

double timeOf(std::string_view tag, const std::string& path) {
  const std::string text = attributeOf(tag, "timestep").value_or("0");
  double time = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), time);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(time))
    throw Error(path + ": `timestep`: expected a number, found " + inQuotes(text));
  return time;
}

}  // namespace

bool isCollection(std::string_view path) {
  std::string ending = fs::path(path).extension().string();
  for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".pvd";
}

std::vector<TimeStep> readCollection(const std::string& path) {
  std::map<double, TimeStep> steps;
  bool collection = false;
  forEachTag(readTextFile(path), path, [&](std::string_view tag) {
    collection |= tag.starts_with("<VTKFile") && attributeOf(tag, "type") == "Collection";
    if (!collection || !tag.starts_with("<DataSet")) return;
    const auto file = attributeOf(tag, "file");
    if (!file || file->empty()) throw Error(path + ": a DataSet has no `file`, expected its name");
    TimeStep& step = steps[timeOf(tag, path)];
    step.files.push_back((fs::path(path).parent_path() / *file).string());
  });
  if (!collection) throw Error(path + ": expected a collection, <VTKFile type=\"Collection\">");
  if (steps.empty()) throw Error(path + ": it names no file, expected a DataSet or more");
  std::vector<TimeStep> out;
  for (auto& [time, step] : steps) {
    step.time = time;
    if (!out.empty() && step.files.size() != out[0].files.size())
      throw Error(path + ": " + std::to_string(step.files.size()) + " files at time " + numberText(time) +
                  ", but " + std::to_string(out[0].files.size()) + " at " + numberText(*out[0].time) +
                  "; expected equally many");
    out.push_back(std::move(step));
  }
  return out;
}

}  // namespace gxy
