// SPDX-License-Identifier: Apache-2.0
// The members of the JSON object of a request.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "multiserver/protocol/json.h"
#include "multiserver/server/document_reader.h"

namespace gxy::viewer {

/// Members of a request's JSON object, with messages; every one that is there must be asked for.
class Members {
 public:
  Members(DocumentReader& reader, const std::optional<std::string_view>& text, std::string what)
      : object_(text ? reader.object(*text, what) : nlohmann::json::object()), what_(std::move(what)) {}

  const nlohmann::json* find(const char* key) {
    known_ += (known_.empty() ? "`" : ", `") + std::string(key) + "`";
    const auto at = object_.find(key);
    asked_ += at != object_.end();
    return at == object_.end() ? nullptr : &*at;
  }
  int64_t integer(const char* key, int64_t fallback, int64_t least, int64_t most) {
    const nlohmann::json* value = find(key);
    return value ? integerIn(*value, key, least, most) : fallback;
  }
  int64_t integerIn(const nlohmann::json& value, const char* key, int64_t least, int64_t most) {
    if (!value.is_number_integer() || value.get<int64_t>() < least || value.get<int64_t>() > most)
      fail(key, "an integer from " + std::to_string(least) + " to " + std::to_string(most), value);
    return value.get<int64_t>();
  }
  bool flag(const char* key, bool fallback) {
    const nlohmann::json* value = find(key);
    if (value && !value->is_boolean()) fail(key, "true or false", *value);
    return value ? value->get<bool>() : fallback;
  }
  std::string oneOf(const char* key, const std::vector<std::string>& choices) {
    const nlohmann::json* value = find(key);
    if (!value) return choices.front();
    std::string all;
    for (const std::string& choice : choices) {
      if (*value == choice) return choice;
      all += (all.empty() ? "\"" : " or \"") + choice + "\"";
    }
    fail(key, all, *value);
  }
  std::string text(const char* key, const std::string& fallback) {
    const nlohmann::json* value = find(key);
    if (value && !value->is_string()) fail(key, "text", *value);
    return value ? value->get<std::string>() : fallback;
  }
  void expectNoMore() const {
    if (asked_ != object_.size())
      throw Error(what_ + ": there are keys that mean nothing here, expected none but " + known_);
  }
  [[noreturn]] void fail(const char* key, const std::string& expected, const nlohmann::json& found) const {
    throw Error(what_ + ": `" + key + "`: expected " + expected + ", found " +
                inQuotes(protocol::dump(found).substr(0, 60)));
  }

 private:
  const nlohmann::json object_;
  const std::string what_;
  std::string known_;
  size_t asked_ = 0;
};

}  // namespace gxy::viewer
