// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: the kernels that read volumes, in C++ against the three ISPC targets and GLSL.
#include <gtest/gtest.h>

#include <bit>
#include <string_view>

#include "tests/rays/maps.h"
#ifdef GALAXY_VULKAN
#include "tests/rays/field_dialect_glsl.h"
#endif

#define FN inline
#define R(x) real(x)
#define VOLUME const VolumeView&
#define MAP const MapView&
namespace gxy::single {
#include "tests/rays/field_probe.h"
}  // namespace gxy::single
#undef FN
#undef R
#undef VOLUME
#undef MAP

extern "C" {
void field_probe_sse4(const void* map, const void* view, int count, const float* rays, float* out);
void field_probe_avx2(const void* map, const void* view, int count, const float* rays, float* out);
void field_probe_avx512skx(const void* map, const void* view, int count, const float* rays, float* out);
}

namespace gxy::test {
namespace {

struct Target {
  const char* name;
  void (*probe)(const void*, const void*, int, const float*, float*);
};

std::vector<Target> targets() {
  std::vector<Target> all{{"sse4", field_probe_sse4}};
  if (__builtin_cpu_supports("avx2")) all.push_back({"avx2", field_probe_avx2});
  if (__builtin_cpu_supports("avx512vl")) all.push_back({"avx512skx", field_probe_avx512skx});
  return all;
}

constexpr int kRays = 160;

/// Differences of any target from C++, over all probes of random rays; `varied`: values that are not the probe's first.
int differences(const Field& f, const Shown& shown, double lo, double hi, uint64_t seed, int& varied) {
  const View<float> view(f, shown);
  Random random(seed);
  std::vector<float> rays;
  for (int i = 0; i < kRays; i++) {
    const RaySpec r = randomRay(random, f);
    for (double x : {r.o.x, r.o.y, r.o.z, r.d.x, r.d.y, r.d.z}) rays.push_back(float(x));
    for (int k = 0; k < 2; k++) rays.push_back(float(lo + (hi - lo) * random.in(-0.2, 1.2)));
  }
  std::vector<float> expected(size_t(FIELD_PROBES) * kRays), got(expected.size());
  for (int p = 0; p < FIELD_PROBES; p++)
    for (int i = 0; i < kRays; i++) {
      const float* r = &rays[size_t(8 * i)];
      float& x = expected[size_t(p) * kRays + size_t(i)];
      x = single::fieldProbe(view.map(), *view, p, {{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, r[6], r[7]});
      varied += x != expected[size_t(p) * kRays];
    }
  int different = 0;
  const auto compare = [&](const char* target) {
    for (size_t i = 0; i < got.size(); i++) {
      const bool same = std::bit_cast<uint32_t>(got[i]) == std::bit_cast<uint32_t>(expected[i]) ||
                        (std::isnan(got[i]) && std::isnan(expected[i]));
      if (same) continue;
      if (different++ < 3)
        ADD_FAILURE() << target << " probe " << i / kRays << " ray " << i % kRays << ": " << got[i]
                      << ", in C++ " << expected[i];
    }
  };
  for (const Target& target : targets()) {
    target.probe(&view.map(), &*view, kRays, rays.data(), got.data());
    compare(target.name);
  }
#ifdef GALAXY_VULKAN
  got = fieldProbesInGlsl(f, shown, rays, FIELD_PROBES);
  compare("GLSL");
#endif
  return different;
}

Shown randomShown(Random& random, const Field& f, MapShape shape, double lo, double hi) {
  Maps m = randomMaps(random, shape);
  for (auto& p : m.color.points) p.value = lo + (hi - lo) * p.value;
  for (auto& p : m.opacity.points) p.value = lo + (hi - lo) * p.value;
  Shown shown;
  shown.map = compiled(m, f);
  for (size_t i = 0; i < f.macrocells().size(); i++)
    shown.plan.push_back(
        random.below(4) ? planOf(random.scale(0.2, 8), kIntegrators[random.below(2)], random.scale(0.05, 8))
                        : 0);
  for (int n = 1 + random.below(3); n > 0; n--) shown.isovalues.push_back(float(random.in(lo, hi)));
  shown.wide = random.below(4) == 0;
  return shown;
}

void expectSameBits(ScalarType stored, double lo, double hi, int components) {
  Random random(900 + uint64_t(stored) * 10 + uint64_t(components));
  int varied = 0, different = 0;
  for (const MapShape shape : kMapShapes)
    for (int scene = 0; scene < 4; scene++) {
      const Index3 n{2 + random.below(24), 2 + random.below(30), 2 + random.below(30)};
      const Grid grid = gridOf(n, random.point(0.2, 1));
      const int component = components > 1 ? random.below(components + 1) - 1 : 0;
      const bool holes = stored == ScalarType::Float32 && scene == 3;
      const Field f = makeField(
          grid,
          [&](int64_t i, int64_t j, int64_t k, int c) {
            const glm::dvec3 p = 2.0 * (grid.origin + grid.spacing * glm::dvec3(i, j, k));
            if (holes && random.below(30) == 0) return double(NAN);
            return lo + (hi - lo) * std::clamp(turbulence(p + 0.3 * c), 0.0, 1.0);
          },
          stored, components, component);
      const Shown shown = randomShown(random, f, shape, lo, hi);
      different += differences(f, shown, lo, hi, uint64_t(scene), varied);
    }
  EXPECT_EQ(different, 0);
  EXPECT_GT(varied, 20 * FIELD_PROBES * kRays / 5);
}

TEST(FieldDialect, FloatVolumesHaveTheBitsOfCpp) { expectSameBits(ScalarType::Float32, 0, 1, 1); }
TEST(FieldDialect, UInt8VolumesHaveTheBitsOfCpp) { expectSameBits(ScalarType::UInt8, 0, 255, 1); }
TEST(FieldDialect, Int8VolumesHaveTheBitsOfCpp) { expectSameBits(ScalarType::Int8, -120, 120, 1); }
TEST(FieldDialect, UInt16VolumesHaveTheBitsOfCpp) { expectSameBits(ScalarType::UInt16, 0, 60000, 1); }
TEST(FieldDialect, Int16VolumesHaveTheBitsOfCpp) { expectSameBits(ScalarType::Int16, -30000, 30000, 1); }
TEST(FieldDialect, SeveralComponentsHaveTheBitsOfCpp) {
  expectSameBits(ScalarType::Float32, 0, 1, 3);
  expectSameBits(ScalarType::UInt8, 0, 255, 2);
}

}  // namespace
}  // namespace gxy::test
