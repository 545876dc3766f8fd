// SPDX-License-Identifier: Apache-2.0
#include "core/flow/document.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "tests/flow/filters.h"

namespace gxy::flow {
namespace {

using test::live;
using test::made;
using Kind = Defect::Kind;

const test::FewFilters kFew;

std::string errorOfDocument(const Document& document) {
  try {
    CompiledDocument compiled(document, kFew);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

Defect defectOf(const Document& document, const std::string& node) {
  const CompiledDocument compiled(document, kFew);
  return compiled.nodes().at(*compiled.place(node)).defect;
}

TEST(Document, AnInputThatTheFilterDoesNotHaveIsRefused) {
  EXPECT_EQ(errorOfDocument({{live("a"), made("b", "Shift", {{"fild", {"a"}}})}, {}, {}}),
            "dataset \"b\": filter Shift: there is no input `fild`; did you mean `field`?; expected `field`");
}

TEST(Document, ADatasetOfAnotherTypeIsRefusedAndBothAreNamed) {
  EXPECT_EQ(
      errorOfDocument({{live("p", DatasetType::Particles), made("b", "Shift", {{"field", {"p"}}})}, {}, {}}),
      "dataset \"b\": filter Shift: input `field`: expected Volume, found \"p\", which is Particles");
  EXPECT_EQ(errorOfDocument({{live("a"), made("s", "Scatter", {{"field", {"a"}}}, R"({"by":1})"),
                              made("b", "Shift", {{"field", {"s"}}})},
                             {},
                             {}}),
            "dataset \"b\": filter Shift: input `field`: expected Volume, found \"s\", which is Particles");
}

TEST(Document, NumbersAreNeitherInputsNorShown) {
  const DatasetSpec count = made("n", "Count", {{"field", {"a"}}});
  EXPECT_EQ(
      errorOfDocument({{live("a"), count, made("b", "Shift", {{"field", {"n"}}})}, {}, {}}),
      "dataset \"b\": input `field`: expected Volume, found \"n\", of which filter Count makes numbers only");
  EXPECT_EQ(errorOfDocument({{live("a"), count}, {{"v", {"n"}}}, {}}),
            "view \"v\": expected datasets, found \"n\", of which filter Count makes numbers only");
}

TEST(Document, ACycleIsRefusedAndNamed) {
  EXPECT_EQ(errorOfDocument(
                {{made("a", "Shift", {{"field", {"b"}}}), made("b", "Shift", {{"field", {"a"}}})}, {}, {}}),
            "datasets are made of each other, expected no cycle: \"a\" of \"b\" of \"a\"");
}

TEST(Document, NamesAreThereAndEachIsThereOnce) {
  EXPECT_EQ(errorOfDocument({{live("a"), live("a")}, {}, {}}),
            "two datasets named \"a\"; expected each name once");
  EXPECT_EQ(errorOfDocument({{}, {{"v", {}}, {"v", {}}}, {}}),
            "two views named \"v\"; expected each name once");
  EXPECT_EQ(errorOfDocument({{}, {}, {{"o", "a"}, {"o", "a"}}}),
            "two outputs named \"o\"; expected each name once");
  EXPECT_EQ(errorOfDocument({{live("")}, {}, {}}),
            "dataset without a name; expected one by which others can call it");
  EXPECT_EQ(errorOfDocument({{live("a")}, {{"a", {"a"}}}, {{"a", "a"}}}), "") << "three kinds of names";
}

TEST(Document, WrongPropertiesAreRefused) {
  EXPECT_EQ(errorOfDocument({{live("a"), made("b", "Shift", {{"field", {"a"}}}, R"({"by":"far"})")}, {}, {}}),
            "dataset \"b\":1:7: `by`: expected a number, found \"far\"");
  EXPECT_EQ(errorOfDocument({{live("a"), made("b", "Shift", {{"field", {"a"}}}, "3")}, {}, {}}),
            "dataset \"b\": properties: expected a JSON object, found \"3\"");
}

TEST(Document, LimitsAreNamed) {
  Document document;
  for (size_t i = 0; i < kMostNodes; i++) document.datasets.push_back(live("d" + std::to_string(i)));
  EXPECT_EQ(errorOfDocument(document), "");
  document.views.push_back({"v", {}});
  EXPECT_EQ(errorOfDocument(document), "the graph has 1001 nodes; expected at most 1000");
  const std::vector<std::string> names(256, "a");
  Document edges{{live("a")}, {}, {}};
  for (size_t i = 0; i < 16; i++)
    edges.datasets.push_back(made("m" + std::to_string(i), "Add", {{"fields", names}}));
  EXPECT_EQ(errorOfDocument(edges), "");
  edges.outputs.push_back({"o", "a"});
  EXPECT_EQ(errorOfDocument(edges), "the graph has 4097 edges; expected at most 4096");
}

TEST(Document, WhatIsMissingIsTheNodesDefectAndBlocksItsConsumers) {
  const Document document{{live("a"), made("b", "Shift", {}), made("c", "Shift", {{"field", {"b"}}}),
                           made("d", "Shift", {{"field", {"gone"}}}),
                           made("e", "Scatter", {{"field", {"a"}}}), made("f", "Warp", {{"any", {"a"}}})},
                          {},
                          {}};
  const auto expect = [&](const std::string& node, Kind kind, const std::string& by,
                          const std::string& text) {
    const Defect defect = defectOf(document, node);
    EXPECT_EQ(defect.kind, kind) << node;
    EXPECT_EQ(defect.node, by) << node;
    EXPECT_EQ(defect.text, text) << node;
  };
  expect("a", Kind::None, "", "");
  expect("b", Kind::Incomplete, "b", "input `field` is missing, expected Volume");
  expect("c", Kind::Blocked, "b", "input `field` is missing, expected Volume");
  expect("d", Kind::Incomplete, "d", "input `field`: there is no dataset \"gone\"");
  expect("e", Kind::Incomplete, "e", "property `by` is missing");
  expect("f", Kind::Blocked, "f", "there is no filter \"Warp\"");
}

TEST(Document, PropertiesAreTheSameHoweverTheyAreWritten) {
  const auto propertiesOf = [](const std::string& text) {
    const CompiledDocument compiled({{live("a"), made("b", "Shift", {{"field", {"a"}}}, text)}, {}, {}},
                                    kFew);
    return compiled.nodes().at(1).spec.properties;
  };
  EXPECT_EQ(propertiesOf(R"({"by": 1})"), R"({"by":1.0})");
  EXPECT_EQ(propertiesOf(R"({ "by" : 1.0 })"), R"({"by":1.0})");
  EXPECT_EQ(propertiesOf(""), R"({"by":1.0})") << "the default";
}

TEST(Document, ATargetNeedsWhatItShowsAndWhatThatIsMadeOf) {
  const Document document{{made("c", "Add", {{"fields", {"b", "a"}}}), made("b", "Shift", {{"field", {"a"}}}),
                           live("a"), live("other"), made("d", "Shift", {{"field", {"other"}}})},
                          {{"v", {"c", "c", "nobody"}}},
                          {{"o", "v"}, {"p", "d"}}};
  const CompiledDocument compiled(document, kFew);
  const Target* v = compiled.target({TargetId::Kind::View, "v"});
  ASSERT_TRUE(v);
  EXPECT_EQ(v->shows, (std::vector<size_t>{0}));
  EXPECT_EQ(v->sources, (std::vector<size_t>{2}));
  EXPECT_EQ(v->closure, (std::vector<size_t>{2, 1, 0}));
  ASSERT_EQ(v->missing.size(), 1u);
  EXPECT_EQ(v->missing[0].node, "nobody");
  EXPECT_EQ(compiled.target({TargetId::Kind::Output, "o"})->closure, v->closure) << "of a view";
  EXPECT_EQ(compiled.target({TargetId::Kind::Output, "p"})->closure, (std::vector<size_t>{3, 4}));
}

}  // namespace
}  // namespace gxy::flow
