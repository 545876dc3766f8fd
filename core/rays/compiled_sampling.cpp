// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_sampling.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

namespace {

int componentOf(const SampledField& field) { return field.volume->components == 1 ? 0 : field.component; }

bool showsField(const CompiledOperator& op, const SampledField& field) {
  return op.data.volume == field.volume &&
         (field.volume->components == 1 || op.vis.component.value_or(-1) == field.component);
}

void checkField(const SampledField& field, size_t i) {
  if (!field.volume) throw Error("field " + std::to_string(i + 1) + " of a sampling is no volume");
  if (field.component < field.volume->components) return;
  throw Error("field " + std::to_string(i + 1) + " of a sampling is component " +
              std::to_string(field.component) + " of \"" + field.volume->name + "\", which has " +
              std::to_string(field.volume->components) + " (counted from 0)");
}

void addRule(CompiledSampling& sampling, int op, const HitRule& rule) {
  if (rule.hits < 1 || rule.hits > kMostHits)
    throw Error("rays are to end after " + std::to_string(rule.hits) + " hits, expected 1 to " +
                std::to_string(kMostHits));
  sampling.hits.push_back(rule.hits);
  for (const HitCondition& c : rule.conditions) {
    if (c.field < 0 || size_t(c.field) >= sampling.fields.size())
      throw Error("a condition is on field " + std::to_string(c.field + 1) + " of a sampling that has " +
                  std::to_string(sampling.fields.size()));
    if (!(c.least <= c.largest))
      throw Error("a condition asks for values from " + std::to_string(c.least) + " to " +
                  std::to_string(c.largest) + ", expected the smaller number first");
    const Volume& volume = *sampling.fields[size_t(c.field)].volume;
    sampling.conditionOperator.push_back(op);
    sampling.conditionField.push_back(c.field);
    for (const double value : {c.least, c.largest})
      sampling.conditionRange.push_back(float((value - volume.shift) / volume.scale));
  }
}

}  // namespace

CompiledOperator viewOf(const SampledField& field, const RenderSpace& space) {
  const Volume& volume = *field.volume;
  CompiledOperator view;
  view.data.volume = field.volume;
  if (componentOf(field) >= 0) view.vis.component = componentOf(field);
  const glm::dvec3 origin = space.toRender(volume.grid.origin);
  for (int k = 0; k < 3; k++) {
    view.gridOrigin[size_t(k)] = float(origin[k]);
    view.gridInverse[size_t(k)] = float(1 / (volume.grid.spacing[k] * space.scale));
  }
  for (const auto& [partition, block] : volume.blocks)
    if (block.extent.count() > 0) view.parts[partition].block = &block;
  return view;
}

std::shared_ptr<const CompiledSampling> compileSampling(std::shared_ptr<const CompiledScene> scene,
                                                        std::vector<SampledField> fields, int recorded,
                                                        std::vector<HitRule> rules, bool gradient, bool met) {
  auto sampling = std::make_shared<CompiledSampling>();
  if (fields.size() > kMostSampledFields)
    throw Error("a sampling reads " + std::to_string(fields.size()) + " fields, expected at most " +
                std::to_string(kMostSampledFields));
  if (recorded < 0 || size_t(recorded) > fields.size())
    throw Error(std::to_string(recorded) + " fields are to be recorded, but a sampling has " +
                std::to_string(fields.size()));
  if (rules.size() != scene->operators.size())
    throw Error("a sampling has rules for " + std::to_string(rules.size()) + " operators, but there are " +
                std::to_string(scene->operators.size()));
  for (size_t i = 0; i < fields.size(); i++) checkField(fields[i], i);
  sampling->fields = std::move(fields);
  for (size_t i = 0; i < rules.size(); i++) addRule(*sampling, int(i), rules[i]);
  for (const SampledField& field : sampling->fields) sampling->views.push_back(viewOf(field, scene->space));
  for (const CompiledOperator& op : scene->operators)
    for (const SampledField& field : sampling->fields) sampling->isovalueOf.push_back(showsField(op, field));
  sampling->scene = std::move(scene);
  sampling->recorded = recorded;
  sampling->rules = std::move(rules);
  sampling->gradient = gradient;
  sampling->met = met;
  return sampling;
}

void addSample(const CompiledSampling& sampling, const RecordedHit& hit, SampleList& samples) {
  samples.values.resize(size_t(sampling.recorded));
  samples.ray.push_back(hit.ray);
  samples.hit.push_back(hit.hit);
  samples.depth.push_back(hit.depth);
  samples.surface.push_back(hit.surface);
  samples.t.push_back(hit.t);
  // In double from the ray alone, so that it has the same bits whatever the partitions.
  const RenderSpace& space = sampling.scene->space;
  const glm::dvec3 at = glm::dvec3(hit.met.origin) + double(hit.t) * glm::dvec3(hit.met.direction);
  samples.position.push_back(space.centre + at / space.scale);
  for (size_t f = 0; f < samples.values.size(); f++) {
    const Volume& volume = *sampling.fields[f].volume;
    samples.values[f].push_back(float(volume.shift + volume.scale * hit.values[f * hit.stride]));
  }
  if (sampling.met) samples.met.push_back(hit.met);
  if (!sampling.gradient) return;
  const CompiledOperator& op = sampling.scene->operators[hit.surface];
  const double unit = (op.data.volume ? op.data.volume->scale : 1) * space.scale;
  samples.gradient.emplace_back(glm::dvec3(hit.gradient[0], hit.gradient[1], hit.gradient[2]) * unit);
}

Visualization forSampling(Visualization visualization) {
  visualization.lighting = {};
  visualization.lighting.sources.clear();
  for (Vis& vis : visualization.operators) {
    vis.volumeRendering = false;
    vis.opacity = 0.5;
  }
  return visualization;
}

}  // namespace gxy
