// SPDX-License-Identifier: Apache-2.0
// A parser by recursive descent, one function for each strength of binding.
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "core/analysis/expression.h"
#include "core/analysis/expression_names.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/read_context.h"

namespace gxy {
namespace {

using Op = ExpressionOp;

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// What is written in other languages, and what is written here.
struct Other {
  std::string_view theirs, ours;
};
constexpr std::array kOthers{
    Other{"**", "^"}, Other{"&&", "and"}, Other{"&", "and"}, Other{"||", "or"},
    Other{"|", "or"}, Other{"!", "not"},  Other{"=", "=="},  Other{"%", "a - b * floor(a / b)"}};

enum class TokenKind { Number, Name, Symbol, End };
struct Token {
  TokenKind kind = TokenKind::End;
  std::string_view text;
  size_t position = 0;
};

}  // namespace

class ExpressionParser {
 public:
  explicit ExpressionParser(Expression& made) : made_(made), text_(made.text_) {}

  void parse() {
    advance();
    if (token_.kind == TokenKind::End) fail("there is nothing, expected an expression");
    disjunction();
    if (token_.kind != TokenKind::End) fail(found() + ", expected an operator or the end");
  }

 private:
  /// Counts what is inside each other, so that no text overflows the stack.
  class Inside {
   public:
    explicit Inside(ExpressionParser& parser) : parser_(parser) {
      if (++parser.depth_ > Expression::kMostDepth)
        parser.fail("more than " + std::to_string(Expression::kMostDepth) + " levels inside each other");
    }
    ~Inside() { --parser_.depth_; }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    ExpressionParser& parser_;
  };

  [[noreturn]] void fail(const std::string& what) const { made_.fail(token_.position, what); }

  std::string found() const {
    return token_.kind == TokenKind::End ? "the expression ends here" : "found " + inQuotes(token_.text, '`');
  }

  void advance() {
    while (next_ < text_.size() &&
           (text_[next_] == ' ' || text_[next_] == '\t' || text_[next_] == '\n' || text_[next_] == '\r'))
      ++next_;
    const size_t first = next_;
    token_ = {TokenKind::End, {}, first};
    if (first == text_.size()) return;
    const char c = text_[first];
    const bool number = isDigit(c) || (c == '.' && first + 1 < text_.size() && isDigit(text_[first + 1]));
    if (number)
      scanNumber();
    else if (isLetter(c))
      while (next_ < text_.size() && (isLetter(text_[next_]) || isDigit(text_[next_]))) ++next_;
    else
      scanSymbol();
    token_ = {number        ? TokenKind::Number
              : isLetter(c) ? TokenKind::Name
                            : TokenKind::Symbol,
              text_.substr(first, next_ - first), first};
  }

  void scanDigits() {
    while (next_ < text_.size() && isDigit(text_[next_])) ++next_;
  }

  void scanNumber() {
    scanDigits();
    if (next_ < text_.size() && text_[next_] == '.') {
      ++next_;
      scanDigits();
    }
    size_t exponent = next_;
    if (exponent < text_.size() && (text_[exponent] == 'e' || text_[exponent] == 'E')) {
      ++exponent;
      if (exponent < text_.size() && (text_[exponent] == '+' || text_[exponent] == '-')) ++exponent;
      if (exponent < text_.size() && isDigit(text_[exponent])) {
        next_ = exponent;
        scanDigits();
      }
    }
  }

  void scanSymbol() {
    const std::string_view rest = text_.substr(next_);
    for (const std::string_view two : {"<=", ">=", "==", "!="})
      if (rest.starts_with(two)) {
        next_ += 2;
        return;
      }
    for (const Other& other : kOthers)
      if (rest.starts_with(other.theirs))
        fail("found " + inQuotes(other.theirs, '`') + ", expected " + inQuotes(other.ours, '`'));
    if (std::string_view("+-*/^<>()[],.").find(rest[0]) == std::string_view::npos) {
      size_t bytes = 1;  // of a character of UTF-8
      while (bytes < rest.size() && bytes < 4 && (uint8_t(rest[bytes]) & 0xc0) == 0x80) ++bytes;
      fail("unexpected character " + inQuotes(rest.substr(0, bytes), '`'));
    }
    ++next_;
  }

  bool at(std::string_view text) const { return token_.kind != TokenKind::End && token_.text == text; }
  bool take(std::string_view text) {
    const bool there = at(text);
    if (there) advance();
    return there;
  }
  void expect(std::string_view text) {
    if (!take(text)) fail(found() + ", expected " + inQuotes(text, '`'));
  }

  int add(ExpressionNode node) {
    made_.nodes_.push_back(node);
    return int(made_.nodes_.size()) - 1;
  }
  int add(Op op, size_t position, int a = -1, int b = -1, int c = -1) {
    ExpressionNode node;
    node.op = op;
    node.position = uint32_t(position);
    node.operands = {a, b, c};
    return add(node);
  }

  /// Parses operands of `next` with one of the operators between them, from the left.
  template <class Next>
  int chain(std::initializer_list<std::pair<std::string_view, Op>> operators, Next next) {
    int left = next();
    for (;;) {
      std::optional<Op> op;
      for (const auto& [text, which] : operators)
        if (at(text)) op = which;
      if (!op) return left;
      const size_t position = token_.position;
      advance();
      const int right = next();
      left = add(*op, position, left, right);
    }
  }

  int disjunction() {
    return chain({{"or", Op::Or}}, [&] { return chain({{"and", Op::And}}, [&] { return negation(); }); });
  }

  int negation() {
    if (!at("not")) return comparison();
    const Inside inside(*this);
    const size_t position = token_.position;
    advance();
    const int operand = negation();
    return add(Op::Not, position, operand);
  }

  int comparison() {
    const std::pair<std::string_view, Op> operators[] = {{"<", Op::Less},    {"<=", Op::LessEqual},
                                                         {">", Op::Greater}, {">=", Op::GreaterEqual},
                                                         {"==", Op::Equal},  {"!=", Op::NotEqual}};
    const auto compares = [&]() -> std::optional<Op> {
      for (const auto& [text, op] : operators)
        if (at(text)) return op;
      return std::nullopt;
    };
    const int left = sum();
    const std::optional<Op> op = compares();
    if (!op) return left;
    const size_t position = token_.position;
    advance();
    const int right = sum();
    if (compares()) fail("comparisons follow each other, expected `a < b and b < c`");
    return add(*op, position, left, right);
  }

  int sum() {
    return chain({{"+", Op::Add}, {"-", Op::Subtract}}, [&] {
      return chain({{"*", Op::Multiply}, {"/", Op::Divide}}, [&] { return sign(); });
    });
  }

  int sign() {
    const bool minus = at("-");
    if (!minus && !at("+")) return power();
    const Inside inside(*this);
    const size_t position = token_.position;
    advance();
    const int operand = sign();
    return minus ? add(Op::Negate, position, operand) : operand;
  }

  int power() {
    const int base = component();
    if (!at("^")) return base;
    const Inside inside(*this);
    const size_t position = token_.position;
    advance();
    const int exponent = sign();
    return add(Op::Power, position, base, exponent);
  }

  int component() {
    int value = primary();
    // The scanner takes `.0` as a number.
    while (at(".") || (token_.kind == TokenKind::Number && token_.text[0] == '.')) {
      const size_t position = token_.position;
      if (token_.kind == TokenKind::Symbol) advance();
      ExpressionNode node;
      node.op = Op::Component;
      node.position = uint32_t(position);
      node.operands[0] = value;
      node.index = whichComponent();
      value = add(node);
    }
    return value;
  }

  int whichComponent() {
    std::string_view text = token_.text;
    if (text.starts_with('.')) text.remove_prefix(1);
    int which = text == "x" ? 0 : text == "y" ? 1 : text == "z" ? 2 : -1;
    if (which < 0 && !text.empty() && text.size() < 4) {
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), which);
      if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) which = -1;
    }
    if (which < 0) fail(found() + ", expected a component: `.x`, `.y`, `.z`, or `.0`, `.1` and so on");
    advance();
    return which;
  }

  int primary() {
    if (token_.kind == TokenKind::Number) return number();
    if (token_.kind == TokenKind::Name && !isOperatorWord(token_.text)) return name();
    const size_t position = token_.position;
    if (take("(")) {
      const Inside inside(*this);
      const int value = disjunction();
      expect(")");
      return value;
    }
    if (take("[")) {
      const std::vector<int> parts = arguments("]");
      if (parts.size() != 3)
        made_.fail(position,
                   "a list of " + std::to_string(parts.size()) + " values, expected a vector [a, b, c]");
      return add(Op::List, position, parts[0], parts[1], parts[2]);
    }
    fail(found() + ", expected a value");
  }

  int number() {
    ExpressionNode node;
    node.position = uint32_t(token_.position);
    const char *first = token_.text.data(), *last = first + token_.text.size();
    const auto parsed = std::from_chars(first, last, node.number);
    if (parsed.ec == std::errc::result_out_of_range)
      fail("the number " + inQuotes(token_.text, '`') +
           " is too large or too small, expected 1e-307 to 1e308");
    if (parsed.ec != std::errc() || parsed.ptr != last) fail(found() + ", expected a number");
    advance();
    if (token_.kind == TokenKind::Name && token_.position == node.position + size_t(last - first))
      fail(found() + " directly behind a number, expected an operator");
    return add(node);
  }

  int name() {
    const Token name = token_;
    advance();
    if (take("(")) return call(name);
    if (const ExpressionWord* word = wordNamed(name.text)) return add(word->op, name.position);
    ExpressionNode node;
    node.op = Op::Input;
    node.position = uint32_t(name.position);
    auto& names = made_.names_;
    const auto known = numbers_.try_emplace(name.text, int(names.size()));
    if (known.second) names.emplace_back(name.text);
    node.index = known.first->second;
    return add(node);
  }

  int call(const Token& name) {
    const ExpressionFunction* function = functionNamed(name.text);
    if (!function) {
      std::vector<std::string> all;
      for (const ExpressionFunction& f : kExpressionFunctions) all.emplace_back(f.name);
      made_.fail(name.position,
                 "there is no function " + inQuotes(name.text, '`') + suggestion(name.text, all));
    }
    const std::vector<int> given = arguments(")");
    const bool extreme = function->op == Op::Min || function->op == Op::Max;
    if (extreme && given.size() == 1)
      return add(function->op == Op::Min ? Op::MinOf : Op::MaxOf, name.position, given[0]);
    if (extreme ? given.empty() : int(given.size()) != function->arguments)
      made_.fail(name.position,
                 std::string(function->name) + "() has " + std::to_string(given.size()) +
                     (given.size() == 1 ? " argument, expected " : " arguments, expected ") +
                     (extreme ? "1 field, or 2 values or more" : std::to_string(function->arguments)));
    if (!extreme)
      return add(function->op, name.position, given[0], given.size() > 1 ? given[1] : -1,
                 given.size() > 2 ? given[2] : -1);
    int value = given[0];
    for (size_t i = 1; i < given.size(); ++i) value = add(function->op, name.position, value, given[i]);
    return value;
  }

  /// Parses values between commas up to `end`.
  std::vector<int> arguments(std::string_view end) {
    const Inside inside(*this);
    std::vector<int> values;
    if (take(end)) return values;
    do values.push_back(disjunction());
    while (take(","));
    if (!take(end)) fail(found() + ", expected `,` or " + inQuotes(end, '`'));
    return values;
  }

  Expression& made_;
  const std::string_view text_;
  size_t next_ = 0;
  Token token_;
  int depth_ = 0;
  std::map<std::string_view, int> numbers_;  ///< the place of each name in names()
};

Expression::Expression(std::string text) : text_(std::move(text)) {
  if (text_.size() > kMostBytes)
    throw Error("expression: " + std::to_string(text_.size()) + " bytes, expected at most " +
                std::to_string(kMostBytes));
  ExpressionParser(*this).parse();
}

void Expression::fail(size_t position, const std::string& what) const {
  int line = 1, column = 1;
  for (size_t i = 0; i < std::min(position, text_.size()); ++i) {
    if (text_[i] == '\n')
      ++line, column = 1;
    else if ((uint8_t(text_[i]) & 0xc0) != 0x80)
      ++column;
  }
  throw Error("expression, line " + std::to_string(line) + ", column " + std::to_string(column) + ": " +
              what);
}

}  // namespace gxy
