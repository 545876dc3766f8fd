// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/next_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "core/comm/error.h"
#include "core/kernels/single_views.h"
#include "core/rays/fill_views.h"
#include "core/rays/view_pointers.h"
#include "core/scene/json_text.h"

namespace gxy {

namespace {

constexpr uint32_t kDrawNext = 2;  // what Philox draws for, beside the purposes of random_line.h

// A vector of length 1; 0 if it has no direction.
glm::dvec3 unitOrZero(const glm::dvec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(v.x + v.y + v.z)) return glm::dvec3(0);
  return glm::normalize(v / largest);  // whose squares are neither 0 nor infinite
}

glm::dvec3 mirrored(const glm::dvec3& d, const glm::dvec3& n) { return d - 2 * glm::dot(d, n) * n; }

// The direction behind a surface with normal n towards the side of index n2.
glm::dvec3 refracted(const glm::dvec3& d, const glm::dvec3& n, double n1, double n2) {
  const bool up = glm::dot(d, n) > 0;
  const double ratio = up ? n1 / n2 : n2 / n1;
  const glm::dvec3 against = up ? -n : n;
  const double cosine = -glm::dot(d, against), rest = 1 - ratio * ratio * (1 - cosine * cosine);
  return rest < 0 ? mirrored(d, n) : ratio * d + (ratio * cosine - std::sqrt(rest)) * against;
}

// Whether a refracted direction, or one that is mirrored because nothing can be, is on a side of the surface that the smooth normal
// means.
bool isOnItsSide(const glm::dvec3& d, const glm::dvec3& toward, const glm::dvec3& smooth,
                 const glm::dvec3& geometric) {
  const bool goesOn = (glm::dot(d, smooth) > 0) == (glm::dot(toward, smooth) > 0);
  return goesOn == ((glm::dot(d, geometric) > 0) == (glm::dot(toward, geometric) > 0));
}

// The words of a volume's kernels at the place that a ray has met.
struct PlaceInVolume {
  single::ivec3 cell;
  single::vec3 point;
  bool holds;  // data
};
PlaceInVolume placeIn(const single::VolumeView& v, const MetSurface& met, float t) {
  PlaceInVolume place{{0, 0, 0}, {0, 0, 0}, false};
  if (!v.samples) return place;
  const single::VolumeRay ray = single::volumeRay(v, met.origin, met.direction, 0.0f, 1e30f);
  if (!(t >= ray.t0 * 0.999999f && t <= ray.t1 * 1.000001f && ray.t0 <= ray.t1)) return place;
  place.cell = single::cellMet(v, ray.g, t);
  place.point = single::pointAt(ray.g, t);
  place.holds = single::holdsData(single::cellValues(v, place.cell));
  return place;
}

}  // namespace

// What rays have met, in the partitions of this rank.
class NextRays::Hits {
 public:
  explicit Hits(const CompiledSampling& sampling) : sampling_(sampling) {}

  /// The normals of the surface: of itself, and smooth ones; towards higher values, both of length 1, or 0 if there is none.
  struct Normals {
    glm::dvec3 geometric{0}, smooth{0};
  };
  Normals normals(const MetSurface& met, uint32_t surface, float t) {
    const CompiledOperator& op = sampling_.scene->operators[surface];
    Normals n;
    if (met.kind == HIT_SLICE) {
      n.geometric = unitOrZero(op.vis.slices[met.primitive].normal);
    } else if (met.kind == HIT_ISOSURFACE) {
      const single::VolumeView& v = viewOfOperator(surface, met.partition);
      const PlaceInVolume place = placeIn(v, met, t);
      if (!place.holds) return n;
      n.geometric = unitOrZero(single::cellGradientIn(v, place.cell, place.point));
      n.smooth = unitOrZero(single::gradientIn(v, place.cell, place.point));
    } else if (met.kind == HIT_GEOMETRY) {
      const std::array<glm::vec3, 3> p = triangle(met, surface);
      n.geometric = unitOrZero(single::triangleNormal(p[0], p[1], p[2]));
    }
    if (n.smooth == glm::dvec3(0)) n.smooth = n.geometric;
    return n;
  }

  /// The largest number that the place of a hit was computed from here: of the domain, which is 1 wide; of a ray and its triangle.
  float sizeOf(const MetSurface& met, uint32_t surface, float t) {
    if (met.kind != HIT_GEOMETRY) return 0.5f;
    float size = t;
    for (int a = 0; a < 3; a++) size = std::max(size, std::abs(met.origin[a]));
    for (const glm::vec3& p : triangle(met, surface))
      for (int a = 0; a < 3; a++) size = std::max(size, std::abs(p[a]));
    return size;
  }

  glm::dvec3 gradient(const SampledField& field, const MetSurface& met, float t) {
    const single::VolumeView& v = viewOfField(field, met.partition);
    const PlaceInVolume place = placeIn(v, met, t);
    if (!place.holds) return glm::dvec3(0);
    return unitOrZero(glm::dvec3(single::gradientIn(v, place.cell, place.point)) * field.volume->scale);
  }

  glm::dvec3 vector(const SampledField& field, const MetSurface& met, float t) {
    glm::dvec3 value(0);
    for (int a = 0; a < 3; a++) {
      const single::VolumeView& v = viewOfField({field.volume, a}, met.partition);
      const PlaceInVolume place = placeIn(v, met, t);
      if (!place.holds) return glm::dvec3(0);
      value[a] = field.volume->shift +
                 field.volume->scale * double(single::valueIn(single::cellValues(v, place.cell),
                                                              single::fractionIn(place.cell, place.point)));
    }
    return unitOrZero(value);
  }

 private:
  std::array<glm::vec3, 3> triangle(const MetSurface& met, uint32_t surface) const {
    const GeometryInPartition& part = *sampling_.scene->operators[surface].parts.at(met.partition).geometry;
    std::array<glm::vec3, 3> corners;
    for (size_t k = 0; k < 3; k++) {
      const float* p = &part.points[4 * size_t(part.indices[3 * size_t(met.primitive) + k])];
      corners[k] = {p[0], p[1], p[2]};
    }
    return corners;
  }

  const single::VolumeView& view(single::VolumeView& v, const CompiledOperator& op, int partition) {
    ViewPointers pointers;
    const auto found = op.parts.find(partition);
    OperatorInPartition only;
    if (found != op.parts.end()) only.block = found->second.block;
    fillVolumeView(v, op, &only, pointers);
    return v;
  }
  const single::VolumeView& viewOfOperator(uint32_t surface, int partition) {
    const auto [it, made] = ofOperators_.try_emplace({surface, partition});
    return made ? view(it->second, sampling_.scene->operators[surface], partition) : it->second;
  }
  const single::VolumeView& viewOfField(const SampledField& field, int partition) {
    const std::pair key(field.volume.get(), field.component);
    auto op = fields_.find(key);
    if (op == fields_.end()) op = fields_.emplace(key, viewOf(field, sampling_.scene->space)).first;
    const auto [it, made] = ofFields_.try_emplace({key, partition});
    return made ? view(it->second, op->second, partition) : it->second;
  }

  using FieldKey = std::pair<const Volume*, int>;
  const CompiledSampling& sampling_;
  std::map<FieldKey, CompiledOperator> fields_;
  std::map<std::pair<uint32_t, int>, single::VolumeView> ofOperators_;
  std::map<std::pair<FieldKey, int>, single::VolumeView> ofFields_;
};

int mostChildren(const std::vector<NextRule>& rules) {
  int most = 0;
  for (const NextRule& rule : rules) most = std::max(most, rule.children());
  return most;
}

uint64_t checkedFollowingRays(uint64_t begun, uint64_t numbers, int children, int depth) {
  // In double it cannot overflow: 2^64 * 65536^8 is 2^192.
  double all = double(begun), generation = double(begun), highest = double(numbers);
  for (int d = 0; d < depth; d++) {
    generation *= children;
    highest *= children;
    all += generation;
  }
  const std::string which =
      std::to_string(children) + " rays of each hit, " + std::to_string(depth) + " times over";
  if (all > double(kMostFollowingRays))
    throw Error("RaySampler: " + std::to_string(begun) + " rays, with up to " + which + ", may become " +
                numberText(all) + ", expected at most " + std::to_string(kMostFollowingRays) +
                "; choose a smaller `depth` or spawn fewer");
  if (highest > 0x1p63)
    throw Error("RaySampler: rays have numbers up to " + std::to_string(numbers) + ", too large for up to " +
                which + "; choose a smaller `depth`, or points whose ids are smaller");
  return uint64_t(all);
}

NextRays::NextRays(const CompiledSampling& sampling, const SampleList& samples,
                   const std::vector<NextRule>& rules, uint32_t seed, const std::function<void()>& check)
    : children_(uint64_t(std::max(1, mostChildren(rules)))) {
  using Way = NextRule::Way;
  parents_.reserve(size_t(std::count_if(samples.surface.begin(), samples.surface.end(),
                                        [&](uint32_t surface) { return rules[surface].way != Way::Stop; })));
  Hits hits(sampling);
  constexpr size_t kBetweenChecks = 4096;
  for (size_t i = 0; i < samples.size(); i++) {
    if (i % kBetweenChecks == 0) check();
    const uint32_t surface = samples.surface[i];
    const NextRule& rule = rules[surface];
    if (rule.way == Way::Stop || samples.hit[i] + 1 < uint32_t(sampling.hits[surface])) continue;
    const MetSurface& met = samples.met[i];
    const float t = samples.t[i];
    const glm::dvec3 d = unitOrZero(met.direction);
    const Hits::Normals normals = hits.normals(met, surface, t);
    const bool flat = normals.geometric == glm::dvec3(0);
    if (flat && rule.needsNormal()) continue;
    const bool up = glm::dot(d, normals.geometric) > 0;  // the ray came from the side of lower values
    glm::dvec3 toward(0);
    switch (rule.way) {
      case Way::AlongGradient:
        toward = hits.gradient(rule.field, met, t);
        break;
      case Way::AgainstGradient:
        toward = -hits.gradient(rule.field, met, t);
        break;
      case Way::AlongField:
        toward = hits.vector(rule.field, met, t);
        break;
      case Way::Mirror:
        toward = mirrored(d, normals.smooth);
        // A smooth normal may turn a flat ray into the surface.
        if ((glm::dot(toward, normals.geometric) > 0) == up) toward = mirrored(d, normals.geometric);
        break;
      case Way::Refract:
        toward = refracted(d, normals.smooth, rule.n1, rule.n2);
        // Where the two normals are to different sides of the ray, or the new ray is, those of the surface itself count.
        if ((glm::dot(d, normals.smooth) > 0) != up ||
            !isOnItsSide(d, toward, normals.smooth, normals.geometric))
          toward = refracted(d, normals.geometric, rule.n1, rule.n2);
        break;
      case Way::Fixed:
        toward = unitOrZero(rule.direction);
        break;
      default:
        toward = rule.sphere ? glm::dvec3(0, 0, 1) : up ? -normals.geometric : normals.geometric;
    }
    // No gradient, no data, or indices that are too different: there is no way to go.
    if (toward == glm::dvec3(0) || !std::isfinite(toward.x + toward.y + toward.z)) continue;
    Parent parent{};
    parent.number = samples.ray[i];
    parent.depth = samples.depth[i];
    uint32_t c[4] = {uint32_t(parent.number), uint32_t(parent.number >> 32), samples.hit[i],
                     single::drawCounter(0, kDrawNext)};
    single::philox4x32(seed, parent.depth, c[0], c[1], c[2], c[3]);
    parent.shift[0] = c[0], parent.shift[1] = c[1];
    parent.info = RAY_SAMPLE << 16;
    if (!flat && (met.kind == HIT_ISOSURFACE || met.kind == HIT_SLICE)) {
      parent.start = surface << 16 | met.primitive;
      parent.info |= (met.kind == HIT_SLICE ? START_SLICE : START_ISOSURFACE) << 18;
    }
    parent.point = glm::vec3(glm::dvec3(met.origin) + double(t) * glm::dvec3(met.direction));
    parent.geometric = flat ? glm::dvec3(0) : normals.geometric;
    parent.toward = toward;
    parent.size = flat ? -1.0f : hits.sizeOf(met, surface, t);
    parent.spawns = rule.way == Way::Spawn, parent.sphere = rule.sphere, parent.uniform = rule.uniform;
    parent.firstRay = rays_;
    rays_ += uint64_t(rule.children());
    parents_.push_back(parent);
  }
}

glm::vec3 NextRays::directionOf(const Parent& parent, uint64_t child) const {
  if (!parent.spawns) return parent.toward;
  // The R2 sequence (kernels/light.h), shifted.
  const auto index = uint32_t(child);
  const float x = single::unitReal(index * 3242174889u + parent.shift[0]),
              y = single::unitReal(index * 2447445414u + parent.shift[1]);
  if (!parent.sphere && !parent.uniform) return single::cosineDirection(parent.toward, x, y);
  single::vec3 s, t;
  single::tangents(parent.toward, s, t);
  float sine, cosine;
  single::sincos1(6.28318531f * y, sine, cosine);
  const float up = parent.sphere ? 1 - 2 * x : std::max(1 - x, 1e-6f),
              radius = std::sqrt(std::max(0.0f, 1 - up * up));
  return glm::normalize(radius * cosine * s + radius * sine * t + up * parent.toward);
}

RayList NextRays::rays(size_t chunk, const RenderSpace&) const {
  const int n = raysOf(chunk);
  RayList list(n);
  list.resize(n);
  const uint64_t first = uint64_t(chunk) * kChunk;
  auto parent = std::upper_bound(parents_.begin(), parents_.end(), first,
                                 [](uint64_t ray, const Parent& p) { return ray < p.firstRay; });
  --parent;
  for (int i = 0; i < n; i++) {
    const uint64_t ray = first + uint64_t(i);
    while (parent + 1 != parents_.end() && (parent + 1)->firstRay <= ray) ++parent;
    const uint64_t child = ray - parent->firstRay;
    const glm::vec3 d = directionOf(*parent, child);
    BeginningRay begins;
    begins.number = parent->number * children_ + child;
    begins.depth = parent->depth + 1;
    begins.direction = d;
    begins.origin = parent->point;
    begins.info = parent->info;
    begins.start = parent->start;
    if (parent->size >= 0) {
      const bool up = glm::dot(d, parent->geometric) > 0;
      begins.origin =
          single::offsetOrigin(parent->point, up ? parent->geometric : -parent->geometric, parent->size);
      if (up) begins.info |= 1u << 20;
    }
    setRay(list.view(), i, begins);
  }
  return list;
}

}  // namespace gxy
