// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/statement.h"

#include <algorithm>
#include <charconv>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "multiserver/protocol/json.h"

namespace gxy::protocol {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

bool isBlank(char c) { return kBlanks.find(c) != std::string_view::npos; }

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool isVerbCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
         c == '-';
}

// Returns the position after the JSON string that begins the text; npos if the string does not end.
size_t endOfString(std::string_view text) {
  for (size_t i = 1; i < text.size(); i++) {
    if (text[i] == '\\')
      i++;
    else if (text[i] == '"')
      return i + 1;
  }
  return std::string_view::npos;
}

}  // namespace

Statement parseStatement(std::string_view text) {
  text = trimmed(text);
  while (text.ends_with(';')) text = trimmed(text.substr(0, text.size() - 1));
  const auto* end = std::find_if_not(text.begin(), text.end(), isVerbCharacter);
  const std::string_view verb(text.begin(), end);
  const std::string_view rest(end, text.end());
  if (verb.empty() || verb.size() > 128)
    throw Error("statement " + inQuotes(text.substr(0, 40)) + ": expected a verb; `help` lists them");
  if (!rest.empty() && !isBlank(rest.front()) && rest.front() != '{' && rest.front() != '"')
    throw Error("statement " + inQuotes(text.substr(0, 40)) + ": expected a blank after the verb");
  return {std::string(verb), std::string(trimmed(rest))};
}

Arguments::Arguments(std::string_view text, std::string usage)
    : text_(trimmed(text)), usage_(std::move(usage)) {}

// Moves past the first `size` bytes of the rest, and the blanks after them.
void Arguments::advance(size_t size) {
  const std::string_view left = rest().substr(size);
  const size_t blanks = left.find_first_not_of(kBlanks);
  at_ = blanks == std::string_view::npos ? text_.size() : at_ + size + blanks;
}

std::optional<std::string> Arguments::word() {
  if (rest().empty() || rest().front() == '{') return std::nullopt;
  std::string word;
  size_t size;
  if (rest().front() == '"') {
    size = endOfString(rest());
    if (size == std::string_view::npos) fail("a string does not end");
    word = *parseJson(rest().substr(0, size), usage_).string();
  } else {
    size = std::min(rest().find_first_of(kBlanks), rest().size());
    word = rest().substr(0, size);
  }
  advance(size);
  return word;
}

std::string Arguments::expectWord() {
  auto found = word();
  if (!found) fail("a word is missing");
  return *std::move(found);
}

std::optional<double> Arguments::number() {
  const auto found = word();
  if (!found) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(found->data(), found->data() + found->size(), value);
  if (error != std::errc() || end != found->data() + found->size() || value - value != 0)
    fail(inQuotes(*found) + " is not a number");
  return value;
}

bool Arguments::taken(std::string_view word) {
  if (!rest().starts_with(word)) return false;
  const std::string_view after = rest().substr(word.size());
  if (!after.empty() && !isBlank(after.front()) && after.front() != '{') return false;
  advance(word.size());
  return true;
}

std::optional<std::string_view> Arguments::json() {
  if (rest().empty()) return std::nullopt;
  if (rest().front() != '{')
    fail("there is " + inQuotes(rest().substr(0, 40)) + " where a JSON object may be");
  const std::string_view object = rest();
  at_ = text_.size();
  return object;
}

std::string_view Arguments::expectJson() {
  const auto found = json();
  if (!found) fail("a JSON object is missing");
  return *found;
}

std::string_view Arguments::expectJsonOrList() {
  if (rest().empty() || rest().front() != '[') return expectJson();
  const std::string_view list = rest();
  at_ = text_.size();
  return list;
}

void Arguments::expectEnd() const {
  if (!rest().empty()) fail(inQuotes(rest().substr(0, 40)) + " is too much");
}

void Arguments::fail(const std::string& reason) const { throw Error(reason + ", expected `" + usage_ + "`"); }

std::vector<std::string> cutStatements(std::string_view script, std::string& rest) {
  std::vector<std::string> statements;
  size_t begin = 0;
  for (size_t i = 0; i < script.size(); i++) {
    if (script[i] == '"') {
      const size_t length = endOfString(script.substr(i));
      if (length == std::string_view::npos) break;
      i += length - 1;
    } else if (script[i] == ';') {
      const std::string_view statement = trimmed(script.substr(begin, i - begin));
      if (!statement.empty()) statements.emplace_back(statement);
      begin = i + 1;
    }
  }
  rest = script.substr(begin);
  return statements;
}

std::string asWord(std::string_view name) {
  const bool plain = !name.empty() && name.find_first_of(" \t\r\n\";{}\\") == std::string_view::npos;
  return plain ? std::string(name) : dump(std::string(name));
}

}  // namespace gxy::protocol
