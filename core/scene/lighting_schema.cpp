// SPDX-License-Identifier: Apache-2.0
#include "core/scene/schema.h"

namespace gxy {
namespace {

Light readLight(const Found& found) {
  const std::string expected =
      "[x, y, z] or [x, y, z, type] with type 0 (directional), 1 (camera) or 2 (point)";
  const std::vector<double> v = found.numbers(3, 4, expected);
  const double type = v.size() > 3 ? v[3] : double(LightType::Point);
  if (type != 0 && type != 1 && type != 2) found.fail(expected);
  return {LightType(int(type)), {v[0], v[1], v[2]}};
}

void readSources(const Found& found, Lighting& lighting) {
  lighting.sources.clear();
  for (const Found& item : found.list("a list of lights, [x, y, z] or [x, y, z, type]")) {
    lighting.sources.push_back(readLight(item));
  }
}

OrderedJson sources(const Lighting& lighting) {
  OrderedJson out = OrderedJson::array();
  for (const Light& light : lighting.sources)
    out.push_back({light.v.x, light.v.y, light.v.z, int(light.type)});
  return out;
}

}  // namespace

const Schema<Lighting>& lightingSchema() {
  static const Schema<Lighting> schema{
      "lighting",
      {
          customKey<Lighting>(
              "Sources", "list of [x, y, z] or [x, y, z, type]",
              "Lights. Type 0: directional, xyz is the way the light travels (0, 0, 0 means 1, 1, 1); "
              "1: camera, xyz is an offset along its right, up and view axes; 2 (assumed): point at xyz.",
              readSources, sources),
          flagKey("shadows", &Lighting::shadows, "Cast shadows."),
          integerKey("ao count", &Lighting::aoCount, {0, 4096}, "Ambient occlusion rays per hit; 0: none."),
          numberKey("ao radius", &Lighting::aoRadius, kPositive, "Reach of ambient occlusion, world units."),
          numberKey("Ka", &Lighting::Ka, kNonNegative, "Ambient weight."),
          numberKey("Kd", &Lighting::Kd, kNonNegative, "Diffuse weight, shared equally among the lights."),
          numberKey("Ks", &Lighting::Ks, kNonNegative, "Specular weight (Phong)."),
          numberKey("shininess", &Lighting::shininess, kNonNegative, "Phong exponent.")
              .alias({"phong exponent"}),
      }};
  return schema;
}

}  // namespace gxy
