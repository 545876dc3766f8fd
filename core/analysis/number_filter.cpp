// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/number_filter.h"

#include <cmath>
#include <optional>

#include "core/analysis/derive_filter.h"
#include "core/comm/error.h"

namespace gxy {

FilterInfo NumberFilter::info() {
  return {
      "Number",
      1,
      "A number that an expression computes of whole fields, such as `max(p) - min(p)`; or whether a "
      "condition "
      "holds, such as `max(p) > 3`. It tells `value`: a number, true or false, or null where there are no "
      "data. Of unstructured volumes, which are on one mesh, each point counts once, or each cell if the "
      "values are those of cells.",
      {{"any name", kVolumes | kUnstructured, "A field; the expression calls it by this name.",
        FilterPort::Count::AnyName}},
      std::nullopt};
}

std::vector<KeyRow<NumberFilter>> NumberFilter::properties() {
  return {customKey<NumberFilter>(
              "expression", "text",
              "What is computed. [derived-fields.md](derived-fields.md) says what there is.",
              [](const Found& f, NumberFilter& n) { n.expression = readExpression(f); },
              [](const NumberFilter& n) { return OrderedJson(n.expression); })
              .require()};
}

FilterResult NumberFilter::run(FilterRun& run) const {
  std::vector<FieldInput> fields;
  std::vector<MeshInput> meshFields;
  std::optional<Expression> parsed;
  bool logical = false;
  run.begin(0, 1, "number");
  agree(run.ranks, [&] {
    meshFields = meshFieldsOf(run, "Number");
    if (meshFields.empty()) fields = fieldsOf(run, "Number");
    parsed.emplace(expression);
    std::vector<ExpressionInput> inputs;
    for (const FieldInput& f : fields) inputs.push_back({f.name, f.volume->components});
    for (const MeshInput& f : meshFields) inputs.push_back({f.name, f.mesh->components});
    logical = typesOf(*parsed, inputs).back().kind == ValueType::Kind::Logical;
  });
  WorkingMemory working(run);
  DeriveOptions options;
  options.time = run.time();
  options.memory = working.teller();
  const double value = meshFields.empty() ? numberOf(*parsed, fields, run.ranks, options)
                                          : numberOf(*parsed, meshFields, run.ranks, options);
  FilterResult result;
  result.told["value"] = std::isnan(value) ? nlohmann::json()
                         : logical         ? nlohmann::json(value != 0)
                                           : nlohmann::json(value);
  return result;
}

}  // namespace gxy
