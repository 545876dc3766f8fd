// SPDX-License-Identifier: Apache-2.0
#include "gxy/scene/data_files.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string_view>

#include "gxy/comm/error.h"
#include "gxy/scene/collection_file.h"
#include "gxy/scene/read_context.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;

/// The pattern as a regular expression of file names; nothing where it is none.
std::optional<std::regex> patternOf(const std::string& name) {
  static const std::regex number("^%(0[0-9]+)?d");
  std::string out;
  bool pattern = false;
  for (size_t i = 0; i < name.size(); i++) {
    std::smatch found;
    const std::string rest = name.substr(i);
    if (std::regex_search(rest, found, number)) {
      out += "[0-9]+";
      i += size_t(found.length()) - 1;
    } else if (name[i] == '*' || name[i] == '?') {
      out += name[i] == '*' ? ".*" : ".";
    } else {
      if (!std::isalnum(static_cast<unsigned char>(name[i])) && name[i] != '_') out += '\\';
      out += name[i];
      continue;
    }
    pattern = true;
  }
  if (!pattern) return {};
  return std::regex(out);
}

/// Numbers by their value, the rest by its bytes.
bool before(std::string_view a, std::string_view b) {
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  const auto digits = [&](std::string_view s) {
    return s.substr(0, size_t(std::find_if_not(s.begin(), s.end(), isDigit) - s.begin()));
  };
  const auto value = [](std::string_view s) {
    return s.substr(std::min(s.find_first_not_of('0'), s.size()));
  };
  while (!a.empty() && !b.empty()) {
    const std::string_view x = digits(a), y = digits(b);
    if (!x.empty() && !y.empty()) {
      const std::string_view m = value(x), n = value(y);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
      a.remove_prefix(x.size());
      b.remove_prefix(y.size());
    } else {
      if (a[0] != b[0]) return a[0] < b[0];
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() && !b.empty();
}

void expectFile(const std::string& path) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) throw Error(path + ": there is no such file");
  if (fs::is_directory(status)) throw Error(path + ": this is a directory, expected a file of data");
}

}  // namespace

bool isStateFile(const std::string& path) {
  expectFile(path);
  std::string ending = fs::path(path).extension().string();
  for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  if (ending != ".json") return false;
  using nlohmann::json;
  const json text = json::parse(readTextFile(path), nullptr, false);
  if (text.is_discarded() || !text.is_object()) return true;  // whose reader says where it is wrong
  const auto hasAny = [&](std::initializer_list<const char*> keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return text.contains(key); });
  };
  if (hasAny({"Datasets", "Visualization", "Visualizations", "Camera", "Cameras", "Renderer"})) return true;
  if (hasAny({"rawdata", "counts", "type"})) return false;
  throw Error(
      path +
      ": this is neither a state file, which has `Visualizations`, nor a volume's description, which has "
      "`type`, `counts` and `rawdata`");
}

std::vector<std::string> filesOf(const std::string& name) {
  const fs::path path(name);
  std::error_code failed;
  const auto pattern = fs::exists(path, failed) ? std::nullopt : patternOf(path.filename().string());
  if (!pattern) {
    expectFile(name);
    return {name};
  }
  std::vector<std::string> found;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string file = entry.path().filename().string();
    if (std::regex_match(file, *pattern) && entry.is_regular_file(failed))
      found.push_back(path.has_parent_path() ? (folder / file).string() : file);
  }
  if (found.empty()) throw Error(name + ": no file matches this pattern");
  std::sort(found.begin(), found.end(), before);
  return found;
}

std::vector<std::vector<std::string>> stepsOf(const std::vector<std::string>& names) {
  std::vector<std::vector<std::vector<std::string>>> series;  // by name, then step
  size_t steps = 1;
  std::string longest;
  for (const std::string& name : names) {
    auto& mine = series.emplace_back();
    for (const std::string& file : filesOf(name)) {
      if (!isCollection(file)) {
        mine.push_back({file});
        continue;
      }
      for (TimeStep& step : readCollection(file)) {
        for (const std::string& part : step.files) expectFile(part);
        mine.push_back(std::move(step.files));
      }
    }
    if (mine.size() == 1) continue;
    if (steps > 1 && mine.size() != steps)
      throw Error(name + ": it has " + std::to_string(mine.size()) + " steps, but " + longest + " has " +
                  std::to_string(steps) + "; expected equally many");
    steps = mine.size();
    longest = name;
  }
  std::vector<std::vector<std::string>> out(steps);
  for (size_t step = 0; step < steps; step++)
    for (const auto& mine : series)
      for (const std::string& file : mine[mine.size() == 1 ? 0 : step]) out[step].push_back(file);
  return out;
}

}  // namespace gxy
