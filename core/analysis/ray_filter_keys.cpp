// SPDX-License-Identifier: Apache-2.0
// The properties of RaySampler.
#include <algorithm>
#include <glm/geometric.hpp>
#include <iterator>

#include "core/analysis/ray_filter.h"
#include "core/rays/compiled_sampling.h"
#include "core/scene/schema.h"

namespace gxy {

namespace {

constexpr int kMostRayLines = 1 << 30;
constexpr size_t kMostPlanes = 65535;
constexpr size_t kMostListedRays = 100000;  // that a document lists
using RayTarget = RaySampler::Target;
using RayCondition = RaySampler::Condition;

const Schema<RayCondition>& rayConditionSchema() {
  static const Schema<RayCondition> schema{
      "condition",
      {textKey("field", &RayCondition::field, "The input whose values are looked at.").require(),
       customKey<RayCondition>(
           "range", "[least, largest]", "The values for which the condition holds.",
           [](const Found& found, RayCondition& c) {
             const auto range = found.numbers(2, 2, "[least, largest]");
             if (!(range[0] <= range[1])) found.fail("[least, largest] with least <= largest");
             c.least = range[0], c.largest = range[1];
           },
           [](const RayCondition& c) {
             return OrderedJson{c.least, c.largest};
           })
           .require()}};
  return schema;
}

using RayNext = RaySampler::Next;
constexpr const char* kRedirects[] = {"gradient", "against gradient", "field", "mirror",
                                      "refract",  "direction",        "random"};
constexpr const char* kRedirectWords =
    "gradient, against gradient, field, mirror, refract, direction or random";
constexpr const char* kNextWords = "\"stop\", \"continue\", or an object with either `redirect` or `spawn`";

KeyRow<RayNext> eitherKey(const char* name, const char* first, const char* second, bool RayNext::*member,
                          const char* meaning) {
  const std::string type = std::string(first) + " or " + second;
  return customKey<RayNext>(
      name, type, meaning,
      [=](const Found& found, RayNext& next) {
        if (found.text() != first && found.text() != second) found.fail(type);
        next.*member = found.text() == second;
      },
      [=](const RayNext& next) { return OrderedJson(next.*member ? second : first); });
}

const Schema<RayNext>& rayNextSchema() {
  static const Schema<RayNext> schema{
      "next",
      {customKey<RayNext>(
           "redirect", kRedirectWords, "The way that the ray goes on.",
           [](const Found& found, RayNext& next) {
             next.redirect = found.text();
             if (std::count(std::begin(kRedirects), std::end(kRedirects), next.redirect) == 0)
               found.fail(kRedirectWords);
           },
           [](const RayNext& next) {
             return next.redirect.empty() ? OrderedJson() : OrderedJson(next.redirect);
           }),
       customKey<RayNext>(
           "spawn", "integer 1 to 65536", "How many rays begin.",
           [](const Found& found, RayNext& next) {
             next.spawn = found.integer({1, 65536});
           },
           [](const RayNext& next) { return next.spawn > 0 ? OrderedJson(next.spawn) : OrderedJson(); }),
       textKey("field", &RayNext::field, "The input of a gradient, or the vector field."),
       numberKey("n1", &RayNext::n1, kPositive, "The refractive index where values are lower."),
       numberKey("n2", &RayNext::n2, kPositive, "The refractive index where values are higher."),
       vectorKey("direction", &RayNext::direction, "The direction."),
       eitherKey("over", "hemisphere", "sphere", &RayNext::sphere, "Where directions lie."),
       eitherKey("distribution", "cosine", "uniform", &RayNext::uniform, "How they are distributed.")}};
  return schema;
}

void readNext(const Found& found, RayTarget& target) {
  RayNext next;
  if (const std::string* word = found.value.string()) {
    if (*word != "stop" && *word != "continue") found.fail(kNextWords);
    next.goesOn = *word == "continue";
  } else if (found.value.object()) {
    readObject(found.context, found.value, rayNextSchema(), next);
    if (next.redirect.empty() == (next.spawn == 0)) found.fail(kNextWords);
    if (next.redirect == "refract" && !(next.n1 > 0 && next.n2 > 0))
      found.fail("refraction with `n1` and `n2`, numbers > 0");
    if (next.redirect == "field" && next.field.empty()) found.fail("the vector field as `field`");
    if (next.redirect == "direction" && glm::length(next.direction) == 0)
      found.fail("a `direction` that is not 0");
  } else {
    found.fail(kNextWords);
  }
  target.next = next;
}

OrderedJson writeNext(const RayTarget& target) {
  const RayNext& next = target.next;
  if (next.goesOn) return "continue";
  if (next.redirect.empty() && next.spawn == 0) return {};
  OrderedJson out = writeObject(next, rayNextSchema());
  // What was not given is not saved.
  for (const char* name : {"n1", "n2"})
    if (out.contains(name) && out[name] == 0) out.erase(name);
  if (next.direction == glm::dvec3(0)) out.erase("direction");
  return out;
}

KeyRow<RayTarget> planesKey(const char* name, std::vector<Plane> RayTarget::*member, const char* meaning) {
  return customKey<RayTarget>(
      name, "list of [nx, ny, nz, offset]", meaning,
      [=](const Found& found, RayTarget& t) {
        for (const Found& item : found.list("a list of [nx, ny, nz, offset]")) {
          if ((t.*member).size() == kMostPlanes) item.fail("at most 65535 planes");
          (t.*member).push_back(item.plane());
        }
      },
      [=](const RayTarget& t) { return toJson(t.*member); });
}

const Schema<RayTarget>& rayTargetSchema() {
  static const Schema<RayTarget> schema{
      "operator of a RaySampler",
      {textKey("dataset", &RayTarget::dataset, "The input that is met: a volume or triangles.").require(),
       customKey<RayTarget>(
           "component", "integer >= 0", "The component of the volume, counted from 0.",
           [](const Found& found, RayTarget& t) {
             t.component = found.integer({0, 1 << 20});
           },
           [](const RayTarget& t) { return t.component ? OrderedJson(*t.component) : OrderedJson(); })
           .byDefault("the magnitude, if there are several"),
       customKey<RayTarget>(
           "isovalues", "list of numbers", "Isosurfaces of the volume.",
           [](const Found& found, RayTarget& t) {
             t.isovalues = found.numbers(0, 65535, "a list of numbers");
           },
           [](const RayTarget& t) { return t.isovalues.empty() ? OrderedJson() : OrderedJson(t.isovalues); }),
       planesKey("planes", &RayTarget::planes, "Planes n . p = offset, where the volume has data."),
       planesKey("clipplanes", &RayTarget::clipPlanes,
                 "Only what lies on the side n . p >= offset of each is met."),
       customKey<RayTarget>(
           "conditions", "list of objects with `field` and `range`",
           "A hit counts only if all of them hold there. A ray passes others as if there were nothing.",
           [](const Found& found, RayTarget& t) {
             for (const Found& item : found.list("a list of conditions"))
               readObject(item.context, item.value, rayConditionSchema(), t.conditions.emplace_back());
           },
           [](const RayTarget& t) {
             OrderedJson out;
             for (const RayCondition& c : t.conditions) out.push_back(writeObject(c, rayConditionSchema()));
             return out;
           }),
       customKey<RayTarget>(
           "every", "number > 0", "Rays meet the volume at each multiple of this length.",
           [](const Found& found, RayTarget& t) { t.every = found.number(kPositive); },
           [](const RayTarget& t) { return t.every > 0 ? OrderedJson(t.every) : OrderedJson(); })
           .byDefault("none"),
       customKey<RayTarget>(
           "hits", "integer 1 to 65535", "A ray ends here once it has so many hits, of any operators.",
           [](const Found& found, RayTarget& t) {
             t.hits = found.integer({1, double(kMostHits)});
           },
           [](const RayTarget& t) { return t.hits ? OrderedJson(*t.hits) : OrderedJson(); })
           .byDefault("1"),
       customKey<RayTarget>("next", kNextWords, "What follows the hit with which a ray ends here.", readNext,
                            writeNext)
           .byDefault("\"stop\"")}};
  return schema;
}

SampleRay readRay(const Found& found, uint64_t number) {
  const auto r = found.numbers(6, 6, "[x, y, z, dx, dy, dz]");
  const SampleRay ray{number, {r[0], r[1], r[2]}, {r[3], r[4], r[5]}};
  if (glm::length(ray.direction) == 0) found.fail("[x, y, z, dx, dy, dz] with a direction that is not 0");
  return ray;
}

}  // namespace

std::vector<KeyRow<RaySampler>> RaySampler::properties() {
  return {
      customKey<RaySampler>(
          "operators", "list of objects",
          "What rays meet. Each has `dataset`, an input, with `isovalues`, `planes` or `every` (a length) of "
          "a "
          "volume; and may have `component`, `clipplanes`, `conditions`, each with `field`, an input, and "
          "`range`, all of which must hold where a hit is to count, `hits`: a ray ends here once it has so "
          "many, 1 by default, or 65535 with `every` unless other rays follow, and `next`: what follows "
          "then.",
          [](const Found& found, RaySampler& s) {
            for (const Found& item : found.list("a list of operators"))
              readObject(item.context, item.value, rayTargetSchema(), s.operators.emplace_back());
          },
          [](const RaySampler& s) {
            OrderedJson out;
            for (const RayTarget& t : s.operators) out.push_back(writeObject(t, rayTargetSchema()));
            return out;
          })
          .require(),
      integerKey(
          "lines", &RaySampler::lines, {0, kMostRayLines},
          "The number of uniformly distributed lines through the box of the first operator's dataset."),
      customKey<RaySampler>(
          "rays", "list of [x, y, z, dx, dy, dz]", "Rays: where they begin, and their directions.",
          [](const Found& found, RaySampler& s) {
            for (const Found& item : found.list("a list of [x, y, z, dx, dy, dz]")) {
              if (s.rays.size() == kMostListedRays) item.fail("at most 100000 rays");
              s.rays.push_back(readRay(item, s.rays.size()));
            }
          },
          [](const RaySampler& s) {
            OrderedJson out;
            for (const SampleRay& r : s.rays)
              out.push_back(
                  {r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z});
            return out;
          })
          .byDefault("none"),
      textKey("points", &RaySampler::points, "The input from whose particles rays begin, in `direction`."),
      customKey<RaySampler>(
          "direction", "[x, y, z], or text",
          "The direction of rays from `points`, or an input, a volume of three components: then each ray has "
          "the direction of that field at its point, and there is none where the field is 0 or has no data.",
          [](const Found& found, RaySampler& s) {
            if (const std::string* name = found.value.string()) {
              s.directionField = *name;
              if (name->empty()) found.fail("[x, y, z], or the name of an input");
              return;
            }
            s.direction = found.vec3();
            if (glm::length(s.direction) == 0) found.fail("a direction that is not 0");
          },
          [](const RaySampler& s) {
            return s.directionField.empty() ? toJson(s.direction) : OrderedJson(s.directionField);
          }),
      customKey<RaySampler>(
          "camera", "object, as in `Cameras`", "A camera: one ray through the middle of each of its pixels.",
          [](const Found& found, RaySampler& s) { s.camera = readCamera(found); },
          [](const RaySampler& s) {
            return s.camera ? writeObject(*s.camera, cameraSchema()) : OrderedJson();
          })
          .byDefault("none"),
      customKey<RaySampler>(
          "values", "text or list of texts",
          "The inputs, volumes, whose values the points get. What is shown is the first.",
          [](const Found& found, RaySampler& s) {
            readOneOrMany(found, [&](const Found& name) {
              if (s.values.size() == kMostSampledFields) name.fail("at most 16 inputs");
              if (!name.text().empty()) s.values.push_back(name.text());
            });
          },
          [](const RaySampler& s) {
            if (s.values.size() == 1) return OrderedJson(s.values[0]);
            return s.values.empty() ? OrderedJson() : OrderedJson(s.values);
          })
          .byDefault("none"),
      flagKey(
          "gradient", &RaySampler::gradient,
          "Whether points get the gradient of the volume that was met, per unit of the world, as their field "
          "`gradient`."),
      integerKey("depth", &RaySampler::depth, {0, 8},
                 "How many generations of rays may follow the first, by the `next` of operators."),
      integerKey("seed", &RaySampler::seed, {0, 2147483647},
                 "Chooses the random numbers of `lines` and of `next`. The same seed gives the same rays."),
  };
}

}  // namespace gxy
