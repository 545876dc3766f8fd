// SPDX-License-Identifier: Apache-2.0
// Requests as text: a verb, words, and perhaps a JSON object. docs/protocol.md section 4.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gxy::protocol {

struct Statement {
  std::string verb;       ///< "list" or "data.list"
  std::string arguments;  ///< what follows, without blanks around it and without a final `;`
};

/// Throws Error where there is no verb.
Statement parseStatement(std::string_view text);

/// Arguments of a verb, taken one by one.
class Arguments {
 public:
  /// `text` stays where it is as long as this is used. `usage`, as "rename NAME NEW", is what was expected, for messages.
  Arguments(std::string_view text, std::string usage);

  /// The next word: what is there up to a blank, or a JSON string; empty text where a JSON object or the end follows.
  std::optional<std::string> word();
  std::string expectWord();
  /// The next word as a number.
  std::optional<double> number();
  /// The next word, if it is this one.
  bool taken(std::string_view word);

  /// All that is left, which must be a JSON object, or nothing.
  std::optional<std::string_view> json();
  std::string_view expectJson();

  /// Throws Error unless all has been taken.
  void expectEnd() const;
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  std::string_view rest() const { return text_.substr(at_); }
  void advance(size_t size);

  std::string_view text_;  // no copy: it may be long, and work may be
  size_t at_ = 0;
  std::string usage_;
};

/// Cuts a script into statements, which end with `;` outside of JSON strings; blank ones are left out. What follows the
/// last `;` stays in `rest`.
std::vector<std::string> cutStatements(std::string_view script, std::string& rest);

/// A name as a word of a request: as it is, or as a JSON string where it needs to be one.
std::string asWord(std::string_view name);

}  // namespace gxy::protocol
