// SPDX-License-Identifier: Apache-2.0
#include "core/scene/data_files.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/comm/error.h"
#include "core/scene/collection_file.h"
#include "core/scene/read_context.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;

/// A pattern of file names. * and ? match any letters; %d and %04d match one digit or more.
class NamePattern {
 public:
  /// Returns nothing if the name has no pattern. Throws Error for a pattern that is too long.
  static std::optional<NamePattern> of(const std::string& name) {
    NamePattern out;
    bool pattern = false;
    for (size_t i = 0; i < name.size(); i++) {
      Part part{Part::Letter, name[i]};
      if (name[i] == '*') part.kind = Part::Letters;
      if (name[i] == '?') part.kind = Part::AnyLetter;
      if (const size_t length = numberAt(name, i)) {
        part.kind = Part::Digits;
        i += length - 1;
      }
      pattern = pattern || part.kind != Part::Letter;
      out.parts_.push_back(part);
    }
    constexpr size_t kLongest = 255;  // bytes of a file's name
    if (pattern && out.parts_.size() > kLongest)
      throw Error("a pattern of file names has " + std::to_string(out.parts_.size()) +
                  " letters, expected at most " + std::to_string(kLongest));
    return pattern ? std::optional(std::move(out)) : std::nullopt;
  }

  /// Takes time proportional to the product of both lengths: after each letter, `met` marks the places in the
  /// pattern up to which the letters so far can match.
  bool matches(std::string_view name) const {
    std::vector<bool> met(parts_.size() + 1);
    met[0] = true;
    passLetters(met);
    for (const char c : name) {
      std::vector<bool> next(met.size());
      for (size_t i = 0; i < parts_.size(); i++) {
        if (!met[i] || !parts_[i].takes(c)) continue;
        next[i + 1] = true;
        if (parts_[i].kind == Part::Letters || parts_[i].kind == Part::Digits) next[i] = true;
      }
      met = std::move(next);
      passLetters(met);
    }
    return met.back();
  }

 private:
  struct Part {
    enum Kind { Letter, AnyLetter, Letters, Digits } kind;
    char letter;
    bool takes(char c) const {
      return kind == Letter ? c == letter : kind != Digits || (c >= '0' && c <= '9');
    }
  };

  /// Returns the length of %d, %0d or %012d at position `at`, or 0 if there is none.
  static size_t numberAt(const std::string& name, size_t at) {
    if (name[at] != '%') return 0;
    size_t end = at + 1;
    if (end < name.size() && name[end] == '0')
      while (end < name.size() && name[end] >= '0' && name[end] <= '9') end++;
    return end < name.size() && name[end] == 'd' ? end + 1 - at : 0;
  }

  // A * may match no letter.
  void passLetters(std::vector<bool>& met) const {
    for (size_t i = 0; i < parts_.size(); i++)
      if (met[i] && parts_[i].kind == Part::Letters) met[i + 1] = true;
  }

  std::vector<Part> parts_;
};

/// Orders names: numbers in them by value, the rest by bytes.
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
  if (text.is_discarded() || !text.is_object()) return true;  // Its reader says where it is wrong.
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
  const auto pattern = fs::exists(path, failed) ? std::nullopt : NamePattern::of(path.filename().string());
  if (!pattern) {
    expectFile(name);
    return {name};
  }
  std::vector<std::string> found;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string file = entry.path().filename().string();
    if (pattern->matches(file) && entry.is_regular_file(failed))
      found.push_back(path.has_parent_path() ? (folder / file).string() : file);
  }
  if (found.empty()) throw Error(name + ": no file matches this pattern");
  std::sort(found.begin(), found.end(), before);
  return found;
}

std::vector<TimeStep> stepsOfFiles(const std::vector<std::string>& files) {
  std::vector<TimeStep> steps;
  for (const std::string& file : files) {
    if (!isCollection(file)) {
      steps.push_back({{}, {file}});
      continue;
    }
    for (TimeStep& step : readCollection(file)) steps.push_back(std::move(step));
    if (steps.back().files.size() != steps.front().files.size())
      throw Error(file + ": " + std::to_string(steps.back().files.size()) + " files in a step, but " +
                  std::to_string(steps.front().files.size()) + " in one of " + files.front() +
                  "; expected equally many");
  }
  return steps;
}

size_t commonSteps(const std::vector<std::string>& names, const std::vector<size_t>& steps) {
  size_t longest = 0;
  for (size_t i = 0; i < steps.size(); i++) {
    if (steps[i] == 1) continue;
    if (steps[longest] > 1 && steps[i] != steps[longest])
      throw Error(names[i] + ": it has " + std::to_string(steps[i]) + " steps, but " + names[longest] +
                  " has " + std::to_string(steps[longest]) + "; expected equally many");
    longest = i;
  }
  return steps.empty() ? 1 : steps[longest];
}

std::vector<TimeStep> stepsOf(const std::vector<std::string>& names) {
  std::vector<std::vector<TimeStep>> series;
  std::vector<size_t> counts;
  for (const std::string& name : names) {
    for (const TimeStep& step : series.emplace_back(stepsOfFiles(filesOf(name))))
      for (const std::string& file : step.files) expectFile(file);
    counts.push_back(series.back().size());
  }
  std::vector<TimeStep> out(commonSteps(names, counts));
  for (size_t n = 0; n < out.size(); n++)
    for (const std::vector<TimeStep>& mine : series) {
      const TimeStep& step = mine[mine.size() == 1 ? 0 : n];
      out[n].files.insert(out[n].files.end(), step.files.begin(), step.files.end());
      if (!out[n].time && mine.size() == out.size()) out[n].time = step.time;
    }
  return out;
}

}  // namespace gxy
