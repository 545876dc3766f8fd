// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/comm/error.h"

namespace gxy {
namespace {

using Op = ExpressionOp;

const std::vector<ExpressionInput> kInputs{{"f", 1}, {"g", 1}, {"u", 3},       {"v", 3},
                                           {"t", 9}, {"w", 2}, {"pressure", 1}};

std::string errorOf(const std::string& text, std::span<const ExpressionInput> inputs = kInputs) {
  try {
    typesOf(Expression(text), inputs);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

std::string typeOf(const std::string& text) {
  const Expression expression(text);
  return nameOf(typesOf(expression, kInputs).back());
}

/// The value of an expression of literals with + - * / ^ and signs.
double valueOf(const std::string& text) {
  const Expression expression(text);
  std::vector<double> values;
  for (const ExpressionNode& node : expression.nodes()) {
    const auto a = [&] { return values[size_t(node.operands[0])]; };
    const auto b = [&] { return values[size_t(node.operands[1])]; };
    switch (node.op) {
      case Op::Number:
        values.push_back(node.number);
        break;
      case Op::Negate:
        values.push_back(-a());
        break;
      case Op::Add:
        values.push_back(a() + b());
        break;
      case Op::Subtract:
        values.push_back(a() - b());
        break;
      case Op::Multiply:
        values.push_back(a() * b());
        break;
      case Op::Divide:
        values.push_back(a() / b());
        break;
      case Op::Power:
        values.push_back(std::pow(a(), b()));
        break;
      case Op::Less:
        values.push_back(a() < b());
        break;
      case Op::Greater:
        values.push_back(a() > b());
        break;
      case Op::And:
        values.push_back(a() != 0 && b() != 0);
        break;
      case Op::Or:
        values.push_back(a() != 0 || b() != 0);
        break;
      case Op::Not:
        values.push_back(a() == 0);
        break;
      default:
        values.push_back(NAN);
    }
  }
  return values.back();
}

TEST(Expression, OperatorsBindAsInPython) {
  const std::map<std::string, double> cases{{"1 + 2 * 3", 7},
                                            {"(1 + 2) * 3", 9},
                                            {"8 - 4 - 2", 2},
                                            {"64 / 4 / 2", 8},
                                            {"2 ^ 3 ^ 2", 512},
                                            {"-2 ^ 2", -4},
                                            {"(-2) ^ 2", 4},
                                            {"2 ^ -1", 0.5},
                                            {"2 ^ -2 ^ 2", 1 / 16.},
                                            {"- - 3", 3},
                                            {"+3", 3},
                                            {"1 - -1", 2},
                                            {"2 * -3", -6},
                                            {"1e3", 1000},
                                            {".5 + 0.25e+1", 3},
                                            {"1.", 1},
                                            {"not 1 < 2", 0},
                                            {"not not 1 < 2", 1},
                                            {"2 < 1 and 1 < 2 or 1 < 2", 1},
                                            {"1 < 2 or 1 < 2 and 2 < 1", 1},
                                            {"1 + 1 < 3 and 4 > 2 * 1", 1},
                                            {" 1\n+\t2\r", 3}};
  for (const auto& [text, value] : cases) EXPECT_EQ(valueOf(text), value) << text;
}

TEST(Expression, TypesFollowFromOperands) {
  const std::map<std::string, std::string> cases{{"f", "scalar field"},
                                                 {"u", "vector field"},
                                                 {"t", "tensor field"},
                                                 {"3", "number"},
                                                 {"[1, 2, 3]", "vector"},
                                                 {"u.x", "scalar field"},
                                                 {"u.2", "scalar field"},
                                                 {"w.1", "scalar field"},
                                                 {"t.8", "scalar field"},
                                                 {"[1, 2, 3].y", "number"},
                                                 {"[f, 2, 3]", "vector field"},
                                                 {"f < g", "logical field"},
                                                 {"1 < 2", "logical number"},
                                                 {"grad(f)", "vector field"},
                                                 {"grad(x * y)", "vector field"},
                                                 {"curl(u)", "vector field"},
                                                 {"div(u)", "scalar field"},
                                                 {"jacobian(u)", "tensor field"},
                                                 {"q(u)", "scalar field"},
                                                 {"q(jacobian(u))", "scalar field"},
                                                 {"lambda2(2 * t)", "scalar field"},
                                                 {"laplacian(f)", "scalar field"},
                                                 {"dot(u, v)", "scalar field"},
                                                 {"cross(u, [0, 0, 1])", "vector field"},
                                                 {"mag(u)", "scalar field"},
                                                 {"norm(u)", "vector field"},
                                                 {"2 * u", "vector field"},
                                                 {"u * f", "vector field"},
                                                 {"u / f", "vector field"},
                                                 {"-t", "tensor field"},
                                                 {"u + v", "vector field"},
                                                 {"max(f, g)", "scalar field"},
                                                 {"max(f, 1, g)", "scalar field"},
                                                 {"max(f)", "number"},
                                                 {"min(mag(u)) + 1", "number"},
                                                 {"quantile(f, 0.9)", "number"},
                                                 {"mean(f) > 3", "logical number"},
                                                 {"f > mean(f)", "logical field"},
                                                 {"sum(f)", "number"},
                                                 {"if(f > 1, u, v)", "vector field"},
                                                 {"if(f > 1, f, nodata)", "scalar field"},
                                                 {"nodata(f)", "logical field"},
                                                 {"x + time", "scalar field"},
                                                 {"clamp(f, 0, 1)", "scalar field"},
                                                 {"not (f > 1 or g < 1)", "logical field"},
                                                 {"(f > 1) == (g > 1)", "logical field"},
                                                 {"atan2(u.y, u.x)", "scalar field"}};
  for (const auto& [text, type] : cases) EXPECT_EQ(typeOf(text), type) << text;
}

TEST(Expression, FunctionsMayBeNamesOfInputs) {
  const std::vector<ExpressionInput> inputs{{"q", 3}, {"div", 3}, {"max", 1}};
  EXPECT_EQ(errorOf("q(q) + div(div) + max(max) + max(max, 2)", inputs), "");
}

TEST(Expression, NamesComeInTheOrderOfTheirFirstUse) {
  const std::vector<std::string> expected{"u", "f", "g"};
  EXPECT_EQ(Expression("u.x * f + g * f + u.y + sin(x) + time").names(), expected);
}

TEST(Expression, EveryWrongTextHasItsMessage) {
  const std::map<std::string, std::string> cases{
      {"", "line 1, column 1: there is nothing, expected an expression"},
      {" \n ", "line 2, column 2: there is nothing, expected an expression"},
      {"f +", "line 1, column 4: the expression ends here, expected a value"},
      {"f + * g", "line 1, column 5: found `*`, expected a value"},
      {"f g", "line 1, column 3: found `g`, expected an operator or the end"},
      {"(f", "line 1, column 3: the expression ends here, expected `)`"},
      {"f)", "line 1, column 2: found `)`, expected an operator or the end"},
      {"sin f", "line 1, column 5: found `f`, expected an operator or the end"},
      {"sin(f", "line 1, column 6: the expression ends here, expected `,` or `)`"},
      {"2 f", "line 1, column 3: found `f`, expected an operator or the end"},
      {"2f", "line 1, column 2: found `f` directly behind a number, expected an operator"},
      {"f ** 2", "line 1, column 3: found `**`, expected `^`"},
      {"f < 1 && g < 1", "line 1, column 7: found `&&`, expected `and`"},
      {"f < 1 || g < 1", "line 1, column 7: found `||`, expected `or`"},
      {"!(f < 1)", "line 1, column 1: found `!`, expected `not`"},
      {"f = 1", "line 1, column 3: found `=`, expected `==`"},
      {"f % 2", "line 1, column 3: found `%`, expected `a - b * floor(a / b)`"},
      {"0 < f < 1", "line 1, column 7: comparisons follow each other, expected `a < b and b < c`"},
      {"f + $", "line 1, column 5: unexpected character `$`"},
      {"f\n+ \xc3\xa9\n+ $", "line 2, column 3: unexpected character `\xc3\xa9`"},
      {"1e999", "line 1, column 1: the number `1e999` is too large or too small, expected 1e-307 to 1e308"},
      {"[1, 2]", "line 1, column 1: a list of 2 values, expected a vector [a, b, c]"},
      {"u.w", "line 1, column 3: found `w`, expected a component: `.x`, `.y`, `.z`, or `.0`, `.1` and so on"},
      {"crl(u)", "line 1, column 1: there is no function `crl`; did you mean `curl`?"},
      {"frobnicate(u)", "line 1, column 1: there is no function `frobnicate`"},
      {"sin(f, g)", "line 1, column 1: sin() has 2 arguments, expected 1"},
      {"if(f > 1, f)", "line 1, column 1: if() has 2 arguments, expected 3"},
      {"max()", "line 1, column 1: max() has 0 arguments, expected 1 field, or 2 values or more"},
      {"quantile(f)", "line 1, column 1: quantile() has 1 argument, expected 2"},
      {"1 + presure",
       "line 1, column 5: unknown name `presure`, expected one of the inputs `f`, `g`, `u`, `v`, `t`, `w`, "
       "`pressure`; did you mean `pressure`?"},
      {"curl", "line 1, column 1: `curl` is a function, expected `(` behind it"},
      {"w + 1",
       "line 1, column 1: `w` has 2 components, expected 1 (a scalar), 3 (a vector) or 9 (a tensor), or one "
       "of its components, as in `w.0`"},
      {"w",
       "line 1, column 1: `w` has 2 components, expected 1 (a scalar), 3 (a vector) or 9 (a tensor), or one "
       "of its components, as in `w.0`"},
      {"w.2", "line 1, column 2: component 2 of 2, expected 0 to 1"},
      {"u.3", "line 1, column 2: component 3 of 3, expected 0 to 2"},
      {"(f + g).x", "line 1, column 8: a component of a scalar field, expected a vector"},
      {"curl(f)", "line 1, column 1: curl() of a scalar field, expected a vector"},
      {"grad(u)", "line 1, column 1: grad() of a vector, expected a scalar; jacobian() is that of a vector"},
      {"grad(3)", "line 1, column 1: grad() of a number, which is the same at all points, expected a field"},
      {"div([1, 2, 3])",
       "line 1, column 1: div() of a number, which is the same at all points, expected a field"},
      {"q(f)", "line 1, column 1: q() of a scalar field, expected a vector"},
      {"f + u", "line 1, column 3: `+` of a scalar field and a vector field, expected two of the same type"},
      {"f + (f > 1)",
       "line 1, column 3: `+` of a scalar field and a logical field, expected two of the same type that are "
       "not logical"},
      {"u * v",
       "line 1, column 3: `*` of a vector field and a vector field, expected a scalar in one place; dot() "
       "and cross() are those of vectors"},
      {"f * (f > 1)",
       "line 1, column 3: `*` of a scalar field and a logical field, expected `and`, or if(c, a, b)"},
      {"f / u", "line 1, column 3: `/` of a vector field, expected a scalar"},
      {"u ^ 2", "line 1, column 3: `^` of a vector field, expected a scalar"},
      {"u < v", "line 1, column 3: `<` of a vector field, expected a scalar"},
      {"f and g", "line 1, column 3: `and` of a scalar field, expected a logical value"},
      {"not f", "line 1, column 1: `not` of a scalar field, expected a logical value"},
      {"-(f > 1)", "line 1, column 1: `-` of a logical value, expected `not`"},
      {"if(f, f, g)",
       "line 1, column 1: the condition of if() is a scalar field, expected a logical value, such as a "
       "comparison"},
      {"if(f > 1, f, u)",
       "line 1, column 1: if() chooses between a scalar field and a vector field, expected two of the same "
       "type"},
      {"sqrt(u)", "line 1, column 1: sqrt() of a vector field, expected a scalar"},
      {"dot(u, f)", "line 1, column 1: dot() of a scalar field, expected a vector"},
      {"[u, f, f]", "line 1, column 1: [a, b, c] of a vector field, expected a scalar"},
      {"max(u)", "line 1, column 1: max() of a vector field, expected a scalar"},
      {"mean(3)", "line 1, column 1: mean() of a number, which is the same at all points, expected a field"},
      {"quantile(f, g)",
       "line 1, column 1: the second argument of quantile() is a field, expected a number from 0 to 1"}};
  for (const auto& [text, message] : cases) EXPECT_EQ(errorOf(text), "expression, " + message) << text;
  EXPECT_EQ(errorOf("u", {}), "expression, line 1, column 1: unknown name `u`, there are no inputs");
}

std::string repeated(const std::string& part, int times, const std::string& end = "") {
  std::string text;
  for (int i = 0; i < times; ++i) text += part;
  return text + end;
}

TEST(Expression, MayBe64KiBLongAndNoLonger) {
  const std::string longest = repeated("f+", 32767, "f ");
  ASSERT_EQ(longest.size(), Expression::kMostBytes);
  EXPECT_EQ(errorOf(longest), "");
  EXPECT_EQ(errorOf(longest + " "), "expression: 65537 bytes, expected at most 65536");
}

TEST(Expression, MayBe64LevelsDeepAndNoDeeper) {
  const std::string refused = "more than 64 levels inside each other";
  const auto nested = [](const std::string& open, const std::string& value, const std::string& close,
                         int levels) { return repeated(open, levels, value) + repeated(close, levels); };
  using Part = std::array<std::string, 3>;
  for (const Part& part : {Part{"(", "f", ")"}, Part{"sin(", "f", ")"}, Part{"-", "f", ""},
                           Part{"2^", "f", ""}, Part{"max(f,", "f", ")"}}) {
    EXPECT_EQ(errorOf(nested(part[0], part[1], part[2], 64)), "") << part[0];
    EXPECT_NE(errorOf(nested(part[0], part[1], part[2], 65)).find(refused), std::string::npos) << part[0];
  }
  EXPECT_NE(errorOf(repeated("[", 60000)).find(refused), std::string::npos);
  EXPECT_NE(errorOf(repeated("not ", 15000)).find(refused), std::string::npos);
  EXPECT_NE(errorOf(repeated("if(", 20000)).find(refused), std::string::npos);
}

TEST(Expression, NumbersMayHaveManyDigits) {
  EXPECT_EQ(valueOf("0." + std::string(60000, '3')), 1 / 3.0);
  EXPECT_EQ(valueOf(std::string(300, '9') + ".5"), 1e300);
  EXPECT_NE(errorOf(std::string(400, '9')).find("too large or too small, expected"), std::string::npos);
  EXPECT_EQ(errorOf(std::string(1000000, '9')), "expression: 1000000 bytes, expected at most 65536");
}

}  // namespace
}  // namespace gxy
