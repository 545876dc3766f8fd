// SPDX-License-Identifier: Apache-2.0
#include "core/scene/json_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/comm/error.h"

namespace gxy {
namespace {

/// Feeds the parser and counts the bytes that it has taken. Copies share the count.
struct CountingIterator {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char* p = nullptr;
  size_t* taken = nullptr;

  reference operator*() const { return *p; }
  CountingIterator& operator++() {
    ++p;
    ++*taken;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator old = *this;
    ++*this;
    return old;
  }
  bool operator==(const CountingIterator& other) const { return p == other.p; }
  bool operator!=(const CountingIterator& other) const { return p != other.p; }
};

bool inNumber(char c) {
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
}
bool betweenTokens(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',' || c == ':'; }

/// Turns ascending byte offsets into positions.
class PositionTracker {
 public:
  explicit PositionTracker(std::string_view text) : text_(text) {}

  TextPosition advanceTo(size_t offset) {
    for (; offset_ < std::min(offset, text_.size()); ++offset_) {
      const auto c = static_cast<unsigned char>(text_[offset_]);
      if (c == '\n') {
        ++at_.line;
        at_.column = 1;
      } else if ((c & 0xC0) != 0x80) {  // not a UTF-8 continuation byte
        ++at_.column;
      }
    }
    return at_;
  }

 private:
  std::string_view text_;
  size_t offset_ = 0;
  TextPosition at_;
};

/// Builds the tree from SAX events, with exact positions of values and keys. The parser reports a token as
/// soon as it has read it, so the count of bytes taken is the token's end (one more after a number). The
/// token's start follows from the previous token's end, because only blanks, commas and colons stand between.
class TreeBuilder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view text, const std::string& sourceName)
      : text_(text), sourceName_(sourceName), tracker_(text) {}

  size_t taken = 0;
  JsonValue root;

  bool null() override { return leaf(nullptr); }
  bool boolean(bool b) override { return leaf(b); }
  bool number_integer(number_integer_t n) override { return leaf(JsonNumber{double(n), true}); }
  bool number_unsigned(number_unsigned_t n) override { return leaf(JsonNumber{double(n), true}); }
  bool number_float(number_float_t x, const string_t&) override {
    return leaf(JsonNumber{x, x == std::floor(x)});
  }
  bool string(string_t& s) override { return leaf(std::move(s)); }
  bool binary(binary_t&) override { return false; }  // Text contains no binary values.

  bool start_object(size_t) override { return open(JsonValue::Object{}); }
  bool start_array(size_t) override { return open(JsonValue::Array{}); }
  bool end_array() override { return close(); }
  bool end_object() override {
    rejectDuplicates(*open_.back().object());
    return close();
  }
  bool key(string_t& name) override {
    const TextPosition at = nextToken();
    std::get<JsonValue::Object>(open_.back().value).push_back({std::move(name), at, {}});
    return true;
  }

  bool parse_error(size_t, const std::string&, const nlohmann::json::exception& e) override {
    const std::string_view what = e.what();
    const size_t last = taken > 0 ? taken - 1 : 0;
    size_t start = tokenStart();
    const bool badCharacter = start < text_.size() && text_[start] == '"' &&
                              what.find("missing closing quote") == std::string_view::npos;
    start = badCharacter || start > last ? last : start;
    if (taken >= text_.size() && tokenStart() >= text_.size()) start = text_.size();  // It ends too early.
    throw Error(locationPrefix(sourceName_, tracker_.advanceTo(start)) + syntaxMessage(what));
  }

 private:
  /// Returns the parser's message without its own position and code: "syntax error while parsing value - ...".
  static std::string syntaxMessage(std::string_view what) {
    if (what.find("number overflow") != std::string_view::npos) {
      return "number too large; expected a finite double";
    }
    const size_t begin = what.find("syntax error");
    std::string message(begin == std::string_view::npos ? what : what.substr(begin));
    const size_t lastRead = message.find("; last read: ");
    if (lastRead != std::string::npos) {
      const size_t end = message.find("'; expected", lastRead);
      message.erase(lastRead, end == std::string::npos ? end : end + 1 - lastRead);
    }
    return message.substr(0, 200);
  }

  size_t tokenStart() const {
    size_t start = previousEnd_;
    while (start < text_.size() && betweenTokens(text_[start])) ++start;
    return start;
  }

  TextPosition nextToken() {
    const size_t start = tokenStart();
    size_t end = taken;
    if (start < text_.size() && inNumber(text_[start])) {
      for (end = start; end < text_.size() && inNumber(text_[end]);) ++end;
    }
    previousEnd_ = end;
    return tracker_.advanceTo(start);
  }

  template <class T>
  bool leaf(T&& value) {
    const TextPosition at = nextToken();
    place({at, std::forward<T>(value)});
    return true;
  }

  bool open(decltype(JsonValue::value) empty) {
    const TextPosition at = nextToken();
    if (open_.size() >= kMaxJsonDepth) {
      throw Error(locationPrefix(sourceName_, at) + "nested deeper than " + std::to_string(kMaxJsonDepth) +
                  " levels");
    }
    open_.push_back({at, std::move(empty)});
    return true;
  }

  bool close() {
    nextToken();
    JsonValue done = std::move(open_.back());
    open_.pop_back();
    place(std::move(done));
    return true;
  }

  void place(JsonValue value) {
    if (++values_ > kMaxJsonValues) {
      throw Error(locationPrefix(sourceName_, value.at) + "more than " + std::to_string(kMaxJsonValues) +
                  " values");
    }
    if (open_.empty()) {
      root = std::move(value);
    } else if (auto* items = std::get_if<JsonValue::Array>(&open_.back().value)) {
      items->push_back(std::move(value));
    } else {
      std::get<JsonValue::Object>(open_.back().value).back().value = std::move(value);
    }
  }

  void rejectDuplicates(const JsonValue::Object& members) const {
    std::vector<const JsonMember*> sorted;
    sorted.reserve(members.size());
    for (const JsonMember& member : members) sorted.push_back(&member);
    std::stable_sort(sorted.begin(), sorted.end(), [](auto* a, auto* b) { return a->key < b->key; });
    const auto twice =
        std::adjacent_find(sorted.begin(), sorted.end(), [](auto* a, auto* b) { return a->key == b->key; });
    if (twice == sorted.end()) return;
    throw Error(locationPrefix(sourceName_, twice[1]->at) + inQuotes(twice[0]->key, '`') +
                ": given twice, first on line " + std::to_string(twice[0]->at.line) + "; expected once");
  }

  std::string_view text_;
  const std::string& sourceName_;
  PositionTracker tracker_;
  std::vector<JsonValue> open_;
  size_t previousEnd_ = 0;
  size_t values_ = 0;
};

}  // namespace

const JsonMember* JsonValue::find(std::string_view key) const {
  const Object* members = object();
  if (!members) return nullptr;
  const auto it =
      std::find_if(members->begin(), members->end(), [&](const JsonMember& m) { return m.key == key; });
  return it == members->end() ? nullptr : &*it;
}

std::string JsonValue::describe() const {
  if (const bool* b = boolean()) return *b ? "true" : "false";
  if (const JsonNumber* n = number()) return numberText(n->value);
  if (const std::string* s = string()) return inQuotes(*s);
  if (const Array* a = array())
    return "an array of " + std::to_string(a->size()) + (a->size() == 1 ? " value" : " values");
  return object() ? "an object" : "null";
}

JsonValue parseJson(std::string_view text, const std::string& sourceName) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  if (text.size() > kMaxJsonBytes) {
    throw Error(sourceName + ": " + std::to_string(text.size()) + " bytes; expected at most " +
                std::to_string(kMaxJsonBytes));
  }
  TreeBuilder builder(text, sourceName);
  const CountingIterator first{text.data(), &builder.taken};
  const CountingIterator last{text.data() + text.size(), &builder.taken};
  nlohmann::json::sax_parse(first, last, &builder);
  return std::move(builder.root);
}

std::string locationPrefix(const std::string& sourceName, TextPosition at) {
  return sourceName + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": ";
}

std::string numberText(double x) {
  if (x == std::floor(x) && std::abs(x) < 1e15) return std::to_string(static_cast<long long>(x));
  return nlohmann::json(x).dump();
}

}  // namespace gxy
