// SPDX-License-Identifier: Apache-2.0
// Requests as text: a verb, words, and optionally a JSON object (docs/protocol.md, section 4).
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gxy::protocol {

struct Statement {
  std::string verb;       ///< "list" or "data.list"
  std::string arguments;  ///< the text after the verb, without surrounding blanks and without a final `;`
};

/// Throws Error if there is no verb.
Statement parseStatement(std::string_view text);

/// Takes the arguments of a verb one by one. Functions throw Error with the reason and the usage.
class Arguments {
 public:
  /// `text` must outlive this object. `usage` ("rename NAME NEW") says in messages what was expected.
  Arguments(std::string_view text, std::string usage);

  /// Takes the next word: the text up to a blank, or a JSON string. Returns nothing if a JSON object or
  /// the end follows.
  std::optional<std::string> word();
  std::string expectWord();
  /// Takes the next word as a number.
  std::optional<double> number();
  /// Takes the next word if it is this one, and returns whether it is.
  bool taken(std::string_view word);

  /// Takes the rest, which must be a JSON object, or nothing.
  std::optional<std::string_view> json();
  std::string_view expectJson();
  /// Takes the rest, which must be a JSON object or list.
  std::string_view expectJsonOrList();

  /// Throws Error unless everything has been taken.
  void expectEnd() const;
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  std::string_view rest() const { return text_.substr(at_); }
  void advance(size_t size);

  std::string_view text_;  // not copied, because it may be long
  size_t at_ = 0;
  std::string usage_;
};

/// Cuts a script into statements. A statement ends with `;` outside of JSON strings; blank statements are
/// left out. The text after the last `;` goes to `rest`.
std::vector<std::string> cutStatements(std::string_view script, std::string& rest);

/// Returns a name as a word of a request: as it is, or as a JSON string if it contains special characters.
std::string asWord(std::string_view name);

}  // namespace gxy::protocol
