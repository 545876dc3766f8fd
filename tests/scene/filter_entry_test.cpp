// SPDX-License-Identifier: Apache-2.0
// Entries of datasets that filters make: what is read, kept, refused, and in which order they are evaluated.
#include "core/scene/filter_schema.h"

#include "core/scene/state_file.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

/// A filter with one property.
struct Shift {
  double by = 1;
};

const Schema<Shift>& shiftSchema() {
  static const Schema<Shift> schema{"filter Shift", {numberKey("by", &Shift::by, kPositive, "How far.")}};
  return schema;
}

class TestFilters final : public FilterSchemas {
 public:
  TestFilters() {
    shift_.name = "Shift";
    shift_.help = "Shifts values.";
    shift_.inputs = {{"field", kVolumes, "What is shifted."},
                     {"points", kParticles | kPathLines, "Where.", FilterPort::Count::Optional}};
    shift_.makes = DatasetType::Volume;
    shift_.read = [](ReadContext& context, const JsonValue& own) {
      Shift shift;
      readObject(context, own, shiftSchema(), shift);
      return writeObject(shift, shiftSchema()).dump();
    };
    sum_.name = "Sum";
    sum_.inputs = {{"fields", kVolumes, "What is added.", FilterPort::Count::Many}};
    sum_.read = shift_.read;
  }
  const FilterSchema* find(const std::string& name) const override {
    return name == "Shift" ? &shift_ : name == "Sum" ? &sum_ : nullptr;
  }
  std::vector<std::string> names() const override { return {"Shift", "Sum"}; }

 private:
  FilterSchema shift_, sum_;
};

const TestFilters kFilters;

std::string errorOfEntry(const std::string& entry) {
  return errorOf([&] { readDatasetEntries(entry, "s", &kFilters); });
}

TEST(FilterEntry, IsReadWithItsInputsAndItsOwnKeys) {
  const StateFile file = readDatasetEntries(
      R"([{"name": "b", "filter": "Shift", "inputs": {"field": "a"}, "by": 2}, {"name": "t", "filter": "Sum", "inputs": {"fields": ["a", "b"]}}])",
      "s", &kFilters);
  EXPECT_TRUE(file.warnings.empty());
  const DatasetSpec& b = file.state.datasets.at(0);
  EXPECT_EQ(b.type, DatasetType::Volume) << "what the filter makes";
  EXPECT_EQ(b.inputs, (std::vector<FilterInput>{{"field", {"a"}}}));
  EXPECT_EQ(b.properties, R"({"by":2.0})");
  EXPECT_EQ(file.state.datasets.at(1).inputs, (std::vector<FilterInput>{{"fields", {"a", "b"}}}));
  EXPECT_EQ(file.state.datasets.at(1).properties, R"({"by":1.0})") << "defaults are filled in";
}

TEST(FilterEntry, MistakesAreErrorsThatSayWhereAndWhatWasExpected) {
  EXPECT_EQ(errorOfEntry(R"({"name": "b", "filter": "Shif"})"),
            "s:1:25: there is no filter \"Shif\"; did you mean `Shift`?; expected one of `Shift`, `Sum`");
  EXPECT_EQ(errorOfEntry(R"({"name": "b", "filter": "Shift"})"),
            "s:1:1: dataset \"b\": filter Shift: input `field` is missing, expected Volume");
  EXPECT_EQ(errorOfEntry(R"({"name": "b", "filter": "Shift", "inputs": {"fild": "a"}})"),
            "s:1:1: dataset \"b\": filter Shift: there is no input `fild`; did you mean `field`?; expected "
            "`field`, `points`");
  EXPECT_EQ(errorOfEntry(R"({"name": "b", "filter": "Shift", "inputs": {"field": ["a", "c"]}})"),
            "s:1:1: dataset \"b\": filter Shift: input `field`: expected one dataset, found 2");
  EXPECT_EQ(errorOfEntry(R"({"filter": "Shift", "inputs": {"field": "a"}})"),
            "s:1:1: filter Shift: `name` is missing, expected that of the dataset to be made");
  EXPECT_EQ(
      errorOfEntry(R"({"name": "b", "type": "Particles", "filter": "Shift", "inputs": {"field": "a"}})"),
      "s:1:1: dataset \"b\": filter Shift makes Volume, found type Particles");
  EXPECT_EQ(
      errorOfEntry("{\"name\": \"b\", \"filter\": \"Shift\", \"inputs\": {\"field\": \"a\"},\n \"by\": -1}"),
      "s:2:8: `by`: expected a number > 0, found -1");
  EXPECT_EQ(errorOfEntry(R"({"name": "b", "filter": 3})"),
            "s:1:25: `filter`: expected text in quotes, found 3");
  EXPECT_EQ(errorOfEntry(R"({"Datasets": [], "Cameras": []})"), "s:1:18: `Cameras`: expected datasets only");
}

TEST(FilterEntry, AnUnknownKeyIsAWarning) {
  const StateFile file = readDatasetEntries(
      R"({"name": "b", "filter": "Shift", "inputs": {"field": "a"}, "bye": 2})", "s", &kFilters);
  EXPECT_EQ(file.warnings,
            std::vector<std::string>{"s:1:60: unknown key `bye` in the filter Shift; did you mean `by`?"});
}

TEST(FilterEntry, OfAnUnknownFilterIsKeptAsItIsWhereNobodyEvaluatesIt) {
  const std::string text =
      R"({"Datasets": [{"name": "x", "type": "PathLines", "filter": "Later", "inputs": {"q": ["a", "b"]}, "deep": {"list": [1, 2.5, null, "t"]}}]})";
  const StateFile file = readState(text, "s");
  EXPECT_TRUE(file.warnings.empty());
  EXPECT_EQ(file.state.datasets.at(0).properties, R"({"deep":{"list":[1,2.5,null,"t"]}})");
  EXPECT_TRUE(readState(writeState(file.state), "s").state == file.state);
}

TEST(FilterEntry, WithoutATypeIsShownByAnyOperatorWhereNobodyKnowsTheFilter) {
  const auto read = [](const std::string& type) {
    return readState(
        R"({"Datasets": [{"name": "x", )" + type + R"("filter": "Later", "inputs": {"q": ["a"]}}],
                         "Visualizations": [{"operators": [{"type": "PathLines", "dataset": "x"}]}]})",
        "s");
  };
  const StateFile file = read("");
  EXPECT_TRUE(file.warnings.empty());
  const std::string written = writeState(file.state);
  EXPECT_EQ(written.find("Volume"), std::string::npos)
      << "whoever knows the filter has its type: " << written;
  EXPECT_TRUE(readState(written, "s").state == file.state);
  EXPECT_TRUE(read(R"("type": "PathLines", )").warnings.empty());
  EXPECT_NE(errorOf([&] { read(R"("type": "Volume", )"); }).find("expected a dataset of type PathLines"),
            std::string::npos);
}

TEST(FilterEntry, InputsOfAnotherTypeAreErrorsThatNameBothSides) {
  DatasetSpec entry =
      readDatasetEntries(R"({"name": "b", "filter": "Shift", "inputs": {"field": "a"}})", "s", &kFilters)
          .state.datasets.at(0);
  const auto check = [&](DatasetType type) {
    checkInputs(*kFilters.find("Shift"), entry, [&](const std::string&) { return type; });
  };
  EXPECT_NO_THROW(check(DatasetType::Volume));
  EXPECT_EQ(errorOf([&] { check(DatasetType::PathLines); }),
            "dataset \"b\": filter Shift: input `field`: expected Volume, found \"a\", which is PathLines");
  entry.inputs.push_back({"points", {"p"}});
  EXPECT_EQ(errorOf([&] { check(DatasetType::Volume); }),
            "dataset \"b\": filter Shift: input `points`: expected Particles or PathLines, found \"p\", "
            "which is Volume");
}

std::vector<DatasetSpec> entries(const std::vector<std::pair<std::string, std::vector<std::string>>>& graph) {
  std::vector<DatasetSpec> all;
  for (const auto& [name, inputs] : graph) {
    DatasetSpec& d = all.emplace_back();
    d.name = name;
    if (inputs.empty()) {
      d.filename = "file";
    } else {
      d.filter = "Sum";
      d.inputs = {{"fields", inputs}};
    }
  }
  return all;
}

TEST(EvaluationOrder, PutsEachAfterWhatItIsMadeOf) {
  EXPECT_EQ(evaluationOrder(entries({{"d", {"b", "c"}}, {"a", {}}, {"c", {"a"}}, {"b", {"a", "else"}}})),
            (std::vector<size_t>{2, 3, 0}));
  std::vector<std::pair<std::string, std::vector<std::string>>> chain{{"0", {}}};
  for (int i = 1; i < 20000; i++) chain.push_back({std::to_string(i), {std::to_string(i - 1)}});
  std::reverse(chain.begin(), chain.end());
  const std::vector<size_t> order = evaluationOrder(entries(chain));
  ASSERT_EQ(order.size(), 19999u);
  EXPECT_TRUE(std::is_sorted(order.rbegin(), order.rend()));
}

TEST(EvaluationOrder, OfACycleIsAnErrorThatNamesIt) {
  EXPECT_EQ(errorOf([] {
              evaluationOrder(entries({{"x", {"a"}}, {"a", {"b"}}, {"b", {"c"}}, {"c", {"a"}}}));
            }),
            "datasets are made of each other, expected no cycle: \"a\" of \"b\" of \"c\" of \"a\"");
  EXPECT_EQ(errorOf([] {
              evaluationOrder(entries({{"a", {"a"}}}));
            }),
            "datasets are made of each other, expected no cycle: \"a\" of \"a\"");
}

}  // namespace
}  // namespace gxy
